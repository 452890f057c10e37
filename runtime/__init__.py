"""Two engines for the same scenario: one process on a counted clock, or supervised processes."""
