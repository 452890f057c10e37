"""The way back of robots that were lost, round those that were not (docs/theory.md, section 17).

Lost robots return together: their slots are those of the formation, shifted by a gap (in the formation's frame) and
turned by an angle, which both fade. A slot of theirs comes near that of a robot which was not lost where the gap is
near the difference of the two offsets. So the way of the gap to zero has to keep off some points of the plane: it is
sought among straight lines by way of points on circles, and the one that costs least is taken.
"""

from collections.abc import Sequence
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from formation.arrays import FloatArray
from formation.pattern import rotate

KEPT = 0.9
"""Share of the least distance between a lost robot's slot and another's that a way keeps, if one does."""
DEARER = 30.0
"""A metre nearer than that costs as much as so many metres of way."""
AROUND = 24
"""Points on a circle."""
CIRCLES = (0.6, 1.0)
"""Radii of the circles, in radii beyond which nothing is near."""
PARTS = 4
"""Of a way on which the formation turns, each taken to be straight."""
LEGS = 4
"""Of a way, at most."""
ALIKE = 0.005
"""Of ways that cost about the same, the one is taken whose next point is nearest to the end [m]."""
SLACK = 0.03
"""Share of what is kept that a robot on its way may lack: it can be a little beside a point that it should pass."""
MOST = 16
"""Larger formations return straight."""


class Ground(NamedTuple):
    """What is in the way of some lost robots, and what the way back costs from where."""

    lost: FloatArray
    """(l, 2) offsets of the lost [m]."""
    others: FloatArray
    """(m, 2) offsets of the others [m]."""
    kept: float
    """Distance that a way shall keep [m]."""
    points: FloatArray
    """(K, 2) by way of which the gap may go; the first is zero [m]."""
    costs: FloatArray
    """(K,) of the way from each point to zero [m]."""

    def shortfall(self, gap: FloatArray, turn: float, points: FloatArray) -> FloatArray:
        """By how much robots come too near where the gap goes straight to points (K, 2), and the turn fades [m]."""
        left = np.linspace(1.0, 0.0, PARTS + 1)
        turned = rotate((left * turn)[:, None], self.lost)
        apart = turned[:, :, None] - self.others  # (PARTS + 1, lost, others, 2)
        shifts = points[:, None] + left[:, None] * (gap - points[:, None])
        ways = shifts[:, :, None, None] + apart
        near = _nearest(ways[:, :-1], ways[:, 1:]).reshape(len(points), -1).min(axis=1)
        short: FloatArray = np.maximum((1.0 - SLACK) * self.kept - near, 0.0)
        return short


class Detour:
    """The next point on the way of lost robots, each time that they hear where the formation is."""

    def __init__(self, ring: Sequence[int]) -> None:
        """Robots as previews pass from one to the next, who knows the path first (numbers, from 1)."""
        self._ring = tuple(ring)

    def via(self, offsets: FloatArray, first: int, gap: FloatArray, turn: float) -> FloatArray:
        """Where the gap should go next, (2,) in the formation's frame: zero if nothing is in the way [m].

        Args:
            offsets: (n, 2) of all robots [m].
            first: of the lost robots; all after it in the ring are lost too.
            gap: (2,) from the place of the formation to that of the lost, in the formation's frame [m].
            turn: by how much the lost are turned against it [rad].
        """
        ground = _ground(self._ring, first, offsets.tobytes())
        if ground is None or ground.shortfall(gap, turn, ground.points[:1])[0] == 0.0:
            return np.zeros(2)
        points = ground.points
        costs = np.hypot(*(points - gap).T) + DEARER * ground.shortfall(gap, turn, points) + ground.costs
        alike = np.flatnonzero(costs <= costs.min() + ALIKE)
        best: FloatArray = points[alike[ground.costs[alike].argmin()]]
        return best


@lru_cache(maxsize=64)
def _ground(ring: tuple[int, ...], first: int, data: bytes) -> Ground | None:
    """For the offsets that have these bytes; None if there is nobody to go round."""
    at = ring.index(first) if first in ring else 0
    if at == 0 or len(ring) > MOST:
        return None
    offsets = np.frombuffer(data).reshape(-1, 2)
    others, lost = (offsets[[robot - 1 for robot in some]] for some in (ring[:at], ring[at:]))
    apart = (others[None] - lost[:, None]).reshape(-1, 2)
    kept = KEPT * float(np.hypot(*apart.T).min())
    reach = float(np.hypot(*lost.T).max() + np.hypot(*others.T).max()) + kept
    angles = np.arange(AROUND) * (2.0 * np.pi / AROUND)
    circle = np.stack([np.cos(angles), np.sin(angles)], axis=-1)
    points = np.concatenate([np.zeros((1, 2)), *(share * reach * circle for share in CIRCLES)])
    legs = np.hypot(*np.moveaxis(points[:, None] - points[None], -1, 0))
    near = _nearest(points[:, None, None] - apart, points[None, :, None] - apart)
    legs += DEARER * np.maximum(kept - near, 0.0)
    costs = legs[:, 0]
    for _ in range(LEGS - 2):
        costs = (legs + costs).min(axis=1)
    return Ground(lost, others, kept, points, costs)


def _nearest(begin: FloatArray, end: FloatArray) -> FloatArray:
    """Distance of the origin from straight lines (..., P, 2), of those along the last axis the least (...) [m]."""
    way = end - begin
    length = np.maximum((way**2).sum(axis=-1), 1e-18)
    at = np.minimum(np.maximum(-(begin * way).sum(axis=-1) / length, 0.0), 1.0)
    near = begin + at[..., None] * way
    found: FloatArray = np.sqrt((near**2).sum(axis=-1).min(axis=-1))
    return found
