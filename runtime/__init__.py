"""Two ways to fly the same scenario: in one process on a counted clock, or as supervised processes."""
