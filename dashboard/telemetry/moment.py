"""A moment of the past, as it is drawn."""

from typing import NamedTuple

from dashboard.telemetry.snapshot import Snapshot
from formation.arrays import FloatArray


class Moment(NamedTuple):
    """What was known then."""

    snapshot: Snapshot
    ghost: FloatArray | None
    """(n, 3) where the ghost was, if there was one [m, m, rad]."""
    offsets: FloatArray
    """(n, 2) of each receiver, from where the robot upstream was to where it believed it to be; NaN if unknown [m]."""
