"""Who takes part in a run, and as what: keys, what each role may do, and numbers of robots."""
