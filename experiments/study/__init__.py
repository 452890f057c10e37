"""Studies: a grid of conditions, seeds, statistics with bands, bounds."""
