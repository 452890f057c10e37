"""The 3D scene: bodies, plans, links, ghost, and the cameras of all pages."""
