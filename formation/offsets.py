"""Offsets of the robots as a function of time: shapes that change smoothly into each other.

A change moves every robot straight from its old offset to its new one on the same smooth clock. With the robots
assigned to the new offsets so that the sum of squared ways is least, and both shapes spaced by at least D, no two
robots come closer than D / sqrt(2) (Turpin, Michael, Kumar: CAPT, Int. J. Robotics Research 33(1), 2014).
"""

from collections.abc import Sequence
from copy import copy
from dataclasses import dataclass

import numpy as np

from formation.arrays import FloatArray, frozen
from formation.formation_spec import Formation
from formation.metrics import clearance, nearest
from formation.paths.path import Path

PEAK = 1.875
"""Largest slope of the smooth step: 15/8."""
SHARE = 0.5
"""How fast a slot moves within the formation at most, as a share of the path's speed: it then keeps going forwards."""
LOOKOUT = 50
"""Times at which the path's slowest speed during a change is sought."""
NEAREST = 0.5
"""Robots that change places keep at least this share of the spacing before and after."""
LOOKOUT_CROWD = 401
"""Times at which the distances during a change are looked at."""
STANDSTILL = 1e-3
"""A path is taken to be no slower than this [m/s] where a change's length is derived."""


@dataclass(frozen=True, slots=True)
class _Move:
    at: float
    over: float
    way: FloatArray
    """(n, 2) [m]."""
    reassigned: bool


class Offsets:
    """Where the robots stand in the body frame at time t."""

    def __init__(self, formation: Formation, path: Path) -> None:
        self._start, self._moves = formation.array, _moves(formation, path)
        reach = np.hypot(*self._start.T).max()
        here = self._start
        for move in self._moves:
            here = here + move.way
            reach = max(reach, np.hypot(*here.T).max())
        self.reach = float(reach)
        """The largest distance of an offset from the centre, at any time [m]."""

    def rows(self, robots: Sequence[int]) -> "Offsets":
        """The same for some robots only (numbers, from 1), in this order."""
        picked = copy(self)
        at = [robot - 1 for robot in robots]
        picked._start = self._start[at]
        picked._moves = tuple(_Move(move.at, move.over, move.way[at], move.reassigned) for move in self._moves)
        return picked

    def after(self, t: float) -> FloatArray:
        """Offsets (n, 2) once the changes that have begun by time t are over [m]."""
        return self._start + sum((move.way for move in self._moves if move.at <= t), np.zeros_like(self._start))

    @property
    def size(self) -> int:
        """Number of robots."""
        return len(self._start)

    @property
    def settled(self) -> float:
        """When the last change is over [s]."""
        return max((move.at + move.over for move in self._moves), default=0.0)

    def crowded(self) -> str:
        """What is wrong with changes in which two robots come too near to each other; empty if nothing is."""
        for number, move in enumerate(self._moves):
            t = move.at + move.over * np.linspace(0.0, 1.0, LOOKOUT_CROWD)
            places = self.at(t)
            allowed = NEAREST * min(nearest(places[0])[2], nearest(places[-1])[2])
            if clearance(places) >= allowed:
                continue
            worst = min(range(len(t)), key=lambda row: nearest(places[row])[2])
            one, other, apart = nearest(places[worst])
            hint = "" if move.reassigned else "; with reassign = true each robot takes the nearest place"
            return (
                f"changes[{number}]: expected robots that keep {allowed:.3g} m apart, half of the spacing; robots "
                f"{one} and {other} come within {apart:.4f} m of each other at t = {t[worst]:.4g} s{hint}"
            )
        return ""

    def moving(self, begin: float, end: float) -> bool:
        """Whether a change is under way between two times [s]."""
        return any(begin <= move.at + move.over and move.at <= end for move in self._moves)

    def at(self, t: FloatArray) -> FloatArray:
        """Offsets (T, n, 2) at times t (T,) [m]; (1, n, 2) if they never change."""
        found = self._start[None]
        for move in self._moves:
            found = found + smooth((t - move.at) / move.over)[:, None, None] * move.way
        return found


def _moves(formation: Formation, path: Path) -> tuple[_Move, ...]:
    moves: list[_Move] = []
    here = formation.array
    for change in formation.changes:
        there = change.array_for(len(here))
        if change.reassign:
            there = there[assignment(here, there)]
        way = there - here
        over = change.over or _time_for(float(np.hypot(*way.T).max()), change.at, path)
        moves.append(_Move(change.at, over, frozen(way), change.reassign))
        here = there
    return tuple(moves)


def assignment(here: FloatArray, there: FloatArray) -> list[int]:
    """Which new offset each robot takes, so that the sum of squared ways is least."""
    from scipy.optimize import linear_sum_assignment  # noqa: PLC0415  half a second, for the few that change shape

    gap = here[:, None] - there[None]
    return [int(j) for j in linear_sum_assignment((gap**2).sum(axis=-1))[1]]


def _time_for(way: float, at: float, path: Path) -> float:
    """How long a change takes whose longest way is `way` [m], so that SHARE is kept [s]."""
    over = 1.0
    for _ in range(20):  # the path may be slower later on: lengthen until it fits
        t = at + over * np.linspace(0.0, 1.0, LOOKOUT)
        step = path.position(t + 0.01) - path.position(t - 0.01)
        speed = max(float(np.hypot(step[:, 0], step[:, 1]).min()) / 0.02, STANDSTILL)
        needed = PEAK * way / (SHARE * speed)
        if needed <= over:
            break
        over = needed
    return over


def smooth(s: FloatArray) -> FloatArray:
    """0 before, 1 after, and a step between with two continuous derivatives: 6 s^5 - 15 s^4 + 10 s^3."""
    s = np.clip(s, 0.0, 1.0)
    return np.asarray(s**3 * (10.0 + s * (6.0 * s - 15.0)))
