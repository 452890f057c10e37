"""The paper's errata: the list, and the evidence for each."""
