"""From which values on something is shown in red."""

DISTANCE_LIMIT = 0.02
"""Error of a pattern distance [m]."""
TRACKING_LIMIT = 0.025
"""Distance of the formation's centre from its path [m]."""
WAITS_SECONDS = 0.05
"""How far a robot may be behind the clock before it is said to wait for somebody, or not to keep up [s]."""
