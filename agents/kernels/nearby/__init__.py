"""Compiled code about the bodies near a robot: what it sees of them, distances in its plan, the last filter."""
