"""What is drawn in 3D: bodies, plans, links, ghost, and from where they are seen."""
