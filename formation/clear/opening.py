"""A change of shape that opens the formation while it lasts, where robots would come too near (theory.md, section 8).

Robots go straight to their new places on one clock; with the best assignment they keep 0.7 of the spacing, which may be
less than two bodies need. Then all places are drawn apart from their mean by a smooth bump, as far as is needed.
"""

from typing import NamedTuple

import numpy as np

from formation.arrays import FloatArray, frozen
from formation.metrics import CROWD, nearest

PEAK = 1.875
"""Largest slope of the smooth step: 15/8."""
ROOM = 1.25
"""Two robots that change places keep so many widths of their bodies between their centres,"""
CLOSE = 0.95
"""but not more than this share of the least distance before and after."""
WIDEST = 1.5
"""By how much the formation opens at most, as a share of its size."""
LOOKOUT = 201
"""Times at which a change is looked at."""


class Opening(NamedTuple):
    """By how much a change opens the formation, and what that costs."""

    by: float
    """At the middle of the change, as a share of its size; 0 where all keep clear without."""
    begin: FloatArray
    """(n, 2) where the change begins, from the mean place [m]."""
    way: FloatArray
    """(n, 2) from there to where it ends, without that of the mean [m]."""
    peak: float
    """The fastest speed of a robot, times the length of the change [m]."""
    reach: float
    """The largest distance of an offset from the centre during the change, if it opens [m]."""

    def at(self, s: FloatArray) -> FloatArray:
        """What the opening adds to the offsets, (T, n, 2) at shares s (T,) of the change's length [m]."""
        s = np.clip(s, 0.0, 1.0)
        return self.by * bump(s)[:, None, None] * (self.begin + smooth(s)[:, None, None] * self.way)

    def rows(self, rows: list[int]) -> "Opening":
        """The same for some robots only, in this order."""
        return self._replace(begin=self.begin[rows], way=self.way[rows])


def opening(here: FloatArray, there: FloatArray, members: list[int], width: float) -> Opening:
    """How a change has to open.

    Args:
        here: offsets (n, 2) where it begins [m].
        there: offsets (n, 2) where it ends [m].
        members: rows of the robots that have a place in the new shape; the others do not move.
        width: of a body; 0 if nobody has one [m].
    """
    way = there - here
    peak, none = PEAK * float(np.hypot(*way.T).max()), np.zeros_like(here)
    closed = Opening(0.0, none, none, peak, 0.0)
    if len(members) < 2 or width <= 0.0:
        return closed
    s: FloatArray = np.linspace(0.0, 1.0, LOOKOUT)
    places = here[members] + smooth(s)[:, None, None] * way[members]
    kept = min(ROOM * width, CLOSE * min(nearest(places[0])[2], nearest(places[-1])[2]))
    apart = _least(places)
    near = apart < kept
    if not near.any():
        return closed
    with np.errstate(divide="ignore"):
        by = min(float(((kept / apart[near] - 1.0) / bump(s[near])).max()), WIDEST)
    begin = none.copy()
    begin[members] = here[members] - here[members].mean(axis=0)
    drawn = none.copy()
    drawn[members] = way[members] - way[members].mean(axis=0)
    opened = Opening(by, frozen(begin), frozen(drawn), peak, 0.0)
    offsets = here + smooth(s)[:, None, None] * way + opened.at(s)
    speed = np.hypot(*np.moveaxis(np.diff(offsets, axis=0), -1, 0)).max() * (LOOKOUT - 1)
    return opened._replace(peak=max(peak, float(speed)), reach=float(np.hypot(*np.moveaxis(offsets, -1, 0)).max()))


def _least(places: FloatArray) -> FloatArray:
    """The least distance of two robots at each time (T,), places (T, n, 2) [m]."""
    if places.shape[1] > CROWD:
        return np.array([nearest(row)[2] for row in places])
    one, other = np.triu_indices(places.shape[1], k=1)
    gaps = places[:, one] - places[:, other]
    found: FloatArray = np.sqrt((gaps**2).sum(axis=-1).min(axis=1))
    return found


def bump(s: FloatArray) -> FloatArray:
    """0 before and after, 1 in the middle, with two continuous derivatives: 64 s^3 (1 - s)^3."""
    s = np.clip(s, 0.0, 1.0)
    return np.asarray(64.0 * (s * (1.0 - s)) ** 3)


def smooth(s: FloatArray) -> FloatArray:
    """0 before, 1 after, and a step between with two continuous derivatives: 6 s^5 - 15 s^4 + 10 s^3."""
    s = np.clip(s, 0.0, 1.0)
    return np.asarray(s**3 * (10.0 + s * (6.0 * s - 15.0)))
