"""Figures and places over simulated time, thinned to what a page can show."""

import numpy as np

from formation.arrays import FloatArray

POINTS = 450
INTERVAL = 0.1
"""Between two rows [s]: 45 s in all. More points than pixels would only cost."""
TRAIL_POINTS = 60
TRAIL_INTERVAL = 0.2
"""Between two points of a trail [s]: 12 s in all."""


class Series:
    """The last rows (stamp, figures...) of a flight; peaks survive the thinning."""

    def __init__(self, figures: int, points: int = POINTS) -> None:
        """No row yet; each will hold so many figures, and the last so many are kept."""
        self._points = points
        self.rows: FloatArray = np.empty((0, 1 + figures))
        self._at = -np.inf

    def add(self, stamp: float, figures: FloatArray) -> None:
        """Take in figures (n,) of a later stamp [s]."""
        if stamp < self._at + INTERVAL - 1e-9 and len(self.rows):
            self.rows[-1, 1:] = np.maximum(self.rows[-1, 1:], figures)
            return
        self._at = stamp
        self.rows = np.concatenate([self.rows[1 - self._points :], [[stamp, *figures]]])


class Trail:
    """Where robots have been lately."""

    def __init__(self, poses: FloatArray, stamp: float) -> None:
        """They come out of nowhere: poses (n, 3) at a stamp [s]."""
        self._places: FloatArray = np.repeat(poses[:, None, :2], TRAIL_POINTS, axis=1)
        self._at = stamp

    def add(self, poses: FloatArray, stamp: float) -> None:
        """They are here at a later stamp [s]."""
        if stamp >= self._at + TRAIL_INTERVAL - 1e-9:
            self._at = stamp
            self._places = np.concatenate([self._places[:, 1:], poses[:, None, :2]], axis=1)

    def up_to(self, poses: FloatArray) -> FloatArray:
        """(n, TRAIL_POINTS, 2), oldest first, up to where the robots are drawn now [m]."""
        if len(self._places) != len(poses):
            return np.repeat(poses[:, None, :2], TRAIL_POINTS, axis=1)
        places = self._places.copy()
        places[:, -1] = poses[:, :2]
        return places
