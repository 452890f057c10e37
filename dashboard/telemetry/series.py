"""Values and positions over simulated time, thinned to what a page can show."""

import numpy as np

from formation.arrays import FloatArray

POINTS = 450
INTERVAL = 0.1
"""Between two rows [s]: 45 s in all. More points than pixels would only cost."""
TRAIL_POINTS = 60
TRAIL_INTERVAL = 0.2
"""Between two points of a trail [s]: 12 s in all."""


class Series:
    """The last rows (stamp, values...) of an episode; thinning keeps the largest value."""

    def __init__(self, values: int, points: int = POINTS) -> None:
        """Begin without rows.

        Args:
            values: number of values in a row.
            points: number of rows kept, the newest ones.
        """
        self._points = points
        self.rows: FloatArray = np.empty((0, 1 + values))
        self._at = -np.inf

    def add(self, stamp: float, values: FloatArray) -> None:
        """Add values (n,) of a later stamp [s]."""
        if stamp < self._at + INTERVAL - 1e-9 and len(self.rows):
            self.rows[-1, 1:] = np.maximum(self.rows[-1, 1:], values)
            return
        self._at = stamp
        self.rows = np.concatenate([self.rows[1 - self._points :], [[stamp, *values]]])


class Trail:
    """The last positions of all robots."""

    def __init__(self, poses: FloatArray, stamp: float) -> None:
        """Begin at poses (n, 3) at a stamp [s], as if the robots had stood there before."""
        self._positions: FloatArray = np.repeat(poses[:, None, :2], TRAIL_POINTS, axis=1)
        self._at = stamp

    def add(self, poses: FloatArray, stamp: float) -> None:
        """Add poses (n, 3) of a later stamp [s]."""
        if stamp >= self._at + TRAIL_INTERVAL - 1e-9:
            self._at = stamp
            self._positions = np.concatenate([self._positions[:, 1:], poses[:, None, :2]], axis=1)

    def up_to(self, poses: FloatArray) -> FloatArray:
        """(n, TRAIL_POINTS, 2), oldest first, ending at the poses that are drawn now [m]."""
        if len(self._positions) != len(poses):
            return np.repeat(poses[:, None, :2], TRAIL_POINTS, axis=1)
        positions = self._positions.copy()
        positions[:, -1] = poses[:, :2]
        return positions
