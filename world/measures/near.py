"""Which bodies are near each other, without looking at every pair: of 1024 there are half a million."""

import numpy as np

from formation.arrays import FloatArray, IntArray

SLACK = 1.0 + 1e-9
"""Of the radius, so that rounding hides nobody."""


def near(places: FloatArray, radius: float) -> tuple[IntArray, IntArray]:
    """Rows (m,) and (m,) of all pairs that may be within a radius of each other, and of few others; the lower first.

    Bodies are sorted along the longer side of their extent; partners are sought within the radius along it.

    Args:
        places: (n, 2 or more) [m].
        radius: [m].
    """
    along = places[:, int(np.ptp(places[:, 1]) > np.ptp(places[:, 0]))]
    order = np.argsort(along, kind="stable")
    line = along[order]
    after = np.arange(len(line)) + 1
    ends = np.maximum(np.searchsorted(line, line + SLACK * radius, side="right"), after)
    counts = ends - after
    one = np.repeat(after - 1, counts)
    other = np.arange(len(one)) - np.repeat(np.cumsum(counts) - counts, counts) + one + 1
    one, other = order[one], order[other]
    return np.minimum(one, other), np.maximum(one, other)
