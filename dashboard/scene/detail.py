"""How finely a formation is drawn, by the number of its robots.

Without a graphics card a frame takes as long as its corners are many, and of a crowd nobody sees them: each robot is
some pixels.
"""

from typing import NamedTuple

import numpy as np

from formation.arrays import FloatArray


class Detail(NamedTuple):
    """What is drawn of each robot's lines and outlines."""

    stride: int
    """From one corner of a line to the next, in points of what it shows."""
    dashes: int
    """Of a link, and to where a robot is believed to be."""
    pattern_dashes: int
    """Between the slots of neighbours."""
    corners: int
    """Of a round outline."""

    def points(self, count: int) -> list[int]:
        """Which of the points of a line are its corners; the ends always are."""
        return [*range(0, count - 1, self.stride), count - 1]

    def thinned(self, lines: FloatArray) -> FloatArray:
        """Of polylines (n, T, 2) those points."""
        return lines if self.stride == 1 else np.ascontiguousarray(lines[:, self.points(lines.shape[1])])


WHOLE = Detail(1, 8, 6, 40)
DETAILS = ((20, WHOLE), (100, Detail(4, 4, 3, 20)))
"""Up to so many robots."""
CROWD = Detail(30, 1, 1, 8)
"""Of more."""


def detail(robots: int) -> Detail:
    """For a formation of so many robots."""
    return next((detail for most, detail in DETAILS if robots <= most), CROWD)
