"""One trial: a scenario with overrides and a seed, simulated; and many of them on all cores."""
