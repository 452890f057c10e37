"""A run that outlives its world: what a world saves of itself, and how another process takes over from there."""
