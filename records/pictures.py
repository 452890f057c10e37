"""What viewers see of a formation besides robots: lines in the map, as markers."""

from collections.abc import Collection, Mapping, Sequence

import numpy as np

from formation.arrays import FloatArray
from formation.link_ids import LinkId
from records.messages import Colour, Lines

GREY, RED = (0.6, 0.6, 0.6, 1.0), (0.84, 0.15, 0.16, 1.0)
BLUE, VIOLET = (0.12, 0.47, 0.71, 1.0), (0.58, 0.4, 0.74, 1.0)
LARGE_ERROR = 0.05
"""A pair's distance error at which its edge is red [m]."""
OLD = 1.0
"""Age of the newest plan at which a link is red [s]."""
WIDTH = 0.004
"""Of lines [m]."""


def edges(poses: FloatArray, errors: FloatArray, away: Collection[int] = ()) -> Lines:
    """From every robot to the one upstream of it, the redder the larger the error (n,) of their distance [m].

    The ring is closed over robots that are away.
    """
    ring = [row for row in range(len(poses)) if row + 1 not in away]
    ends = np.stack([poses[ring, :2], np.roll(poses[ring, :2], 1, axis=0)], axis=1).reshape(-1, 2)
    shares = np.minimum(np.abs(errors[ring]) / LARGE_ERROR, 1.0)
    return Lines("edges", ends, [_mixed(float(share)) for share in shares], WIDTH)


def ways_to(slots: FloatArray, poses: FloatArray) -> Lines:
    """From every robot to its slot."""
    ends = np.stack([poses[:, :2], slots[:, :2]], axis=1).reshape(-1, 2)
    return Lines("slots", ends, [GREY] * len(poses), 0.5 * WIDTH)


def links(poses: FloatArray, ages: Mapping[LinkId, float]) -> Lines:
    """The links that carry plans, the redder the older the newest plan [s]."""
    here = [(link, age) for link, age in ages.items() if min(link) >= 1 and max(link) <= len(poses)]
    ends = [poses[np.array(link) - 1, :2] for link, _ in here]
    points = np.concatenate(ends) if ends else np.zeros((0, 2))
    return Lines("links", points, [_mixed(min(1.0, age / OLD)) for _, age in here], 2.0 * WIDTH)


def curves(namespace: str, lines: Sequence[FloatArray], colour: Colour) -> Lines:
    """Curves, each through points (m, 2 or more) [m]."""
    found = [np.stack([line[:-1, :2], line[1:, :2]], axis=1).reshape(-1, 2) for line in lines if len(line) > 1]
    points = np.concatenate(found) if found else np.zeros((0, 2))
    return Lines(namespace, points, [colour] * (len(points) // 2), 0.5 * WIDTH)


def _mixed(share: float) -> Colour:
    red, green, blue, alpha = (a + share * (b - a) for a, b in zip(GREY, RED, strict=True))
    return red, green, blue, alpha
