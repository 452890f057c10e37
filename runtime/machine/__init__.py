"""What this machine bears, and how the agents of a run share its processes."""
