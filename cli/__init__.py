"""The command line: a thin module per command. `echelon --help` lists them."""
