"""Limits beyond which a value is shown in red, or mentioned."""

DISTANCE_LIMIT = 0.02
"""Error of a pattern distance [m]."""
TRACKING_LIMIT = 0.025
"""Distance of the formation's centre from its path [m]."""
LAG_LIMIT = 0.05
"""Lag of a robot behind the clock, from which on the page mentions it [s]."""
