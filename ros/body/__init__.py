"""A real robot of a run: commands to it, poses from it."""
