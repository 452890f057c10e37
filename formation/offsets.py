"""Offsets of the robots as a function of time: shapes that change smoothly into each other.

A change moves every robot straight from its old offset to its new one on the same smooth clock. With the robots
assigned to the new offsets so that the sum of squared ways is least, and both shapes spaced by at least D, no two
robots come closer than D / sqrt(2) (Turpin, Michael, Kumar: CAPT, Int. J. Robotics Research 33(1), 2014). Where
bodies need more than that, the formation opens while it changes (formation/clear/opening.py).
"""

import math
from collections.abc import Sequence
from copy import copy
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from formation.arrays import FloatArray, frozen
from formation.clear.opening import Opening, opening, smooth
from formation.formation_spec import Formation
from formation.metrics import clearance, nearest
from formation.paths.path import Path

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
    members: list[int]
    """Rows of the robots that have a place in the new shape."""
    opening: Opening


class Reach(NamedTuple):
    """How far a shape reaches, into which the formation changes."""

    at: float
    over: float
    """When the change begins, and how long it takes [s]."""
    reach: float
    """Distance of the outermost offset from the centre [m]."""


class Offsets:
    """Where the robots stand in the body frame at time t."""

    def __init__(self, formation: Formation, path: Path, width: float = 0.0) -> None:
        """The offsets of a formation whose centre follows a path, and whose bodies have this width [m]."""
        self.every = self
        """Those of all robots, of which these may be some."""
        self._start, self._moves = formation.array, _moves(formation, path, width)
        here, self.reaches = self._start, [Reach(-math.inf, 0.0, _reach(self._start))]
        """Of the shapes, one after the other."""
        for move in self._moves:
            here = here + move.way
            self.reaches.append(Reach(move.at, move.over, _reach(here)))
        self.reach = max(*(each.reach for each in self.reaches), *(move.opening.reach for move in self._moves), 0.0)
        """The largest distance of an offset from the centre, at any time [m]."""

    def rows(self, robots: Sequence[int]) -> "Offsets":
        """The same for some robots only (numbers, from 1), in this order."""
        picked = copy(self)
        picked.every = self.every
        at = [robot - 1 for robot in robots]
        picked._start = self._start[at]
        picked._moves = tuple(replace(move, way=move.way[at], opening=move.opening.rows(at)) for move in self._moves)
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
            places = self.at(t)[:, move.members]
            allowed = NEAREST * min(nearest(places[0])[2], nearest(places[-1])[2])
            if clearance(places) >= allowed:
                continue
            worst = min(range(len(t)), key=lambda row: nearest(places[row])[2])
            one, other, apart = nearest(places[worst])
            hint = "" if move.reassigned else "; with reassign = true each robot takes the nearest place"
            pair = f"{move.members[one - 1] + 1} and {move.members[other - 1] + 1}"
            return (
                f"changes[{number}]: expected robots that keep {allowed:.3g} m apart, half of the spacing; robots "
                f"{pair} come within {apart:.4f} m of each other at t = {t[worst]:.4g} s{hint}"
            )
        return ""

    def moving(self, begin: float, end: float) -> bool:
        """Whether a change is under way between two times [s]."""
        return any(begin <= move.at + move.over and move.at <= end for move in self._moves)

    def at(self, t: FloatArray) -> FloatArray:
        """Offsets (T, n, 2) at times t (T,) [m]; (1, n, 2) if they never change."""
        found = self._start[None]
        for move in self._moves:
            s = (t - move.at) / move.over
            found = found + smooth(s)[:, None, None] * move.way
            if move.opening.by:
                found = found + move.opening.at(s)
        return found


def _reach(offsets: FloatArray) -> float:
    return float(np.hypot(*offsets.T).max())


def _moves(formation: Formation, path: Path, width: float) -> tuple[_Move, ...]:
    moves: list[_Move] = []
    here = formation.array
    for change in formation.changes:
        rows, places = change.members(len(here)), change.array_for(len(here))
        if change.reassign:
            places = places[assignment(here[rows], places)]
        there = here.copy()
        there[rows] = places
        way = there - here
        opens = opening(here, there, rows, width)
        over = change.over or _time_for(opens.peak, change.at, path)
        moves.append(_Move(change.at, over, frozen(way), change.reassign, rows, opens))
        here = there
    return tuple(moves)


def assignment(here: FloatArray, there: FloatArray) -> list[int]:
    """Which new offset each robot takes, so that the sum of squared ways is least.

    Robot after robot gets a place by a shortest augmenting path (Crouse, IEEE Trans. Aerospace and Electronic Systems
    52(4), 2016). Of equal ones a free place is taken, else the first that is looked at, the last places first: which of
    several best assignments is found is part of a trajectory. To import scipy for it would stop a live world for long.
    """
    gap = here[:, None] - there[None]
    cost: list[list[float]] = (gap**2).sum(axis=-1).tolist()
    n = len(cost)
    of_robots, of_places = [0.0] * n, [0.0] * n  # dual prices
    taken, taker = [-1] * n, [-1] * n  # place of each robot, robot of each place
    for robot in range(n):
        reach, via, left = [math.inf] * n, [-1] * n, list(range(n - 1, -1, -1))
        seen, length, i = [robot], 0.0, robot
        while True:
            row, price, nearest_yet, at = cost[i], of_robots[i], math.inf, -1
            for place, j in enumerate(left):
                way = length + row[j] - price - of_places[j]
                if way < reach[j]:
                    via[j], reach[j] = i, way
                if reach[j] < nearest_yet or (reach[j] == nearest_yet and taker[j] == -1):
                    nearest_yet, at = reach[j], place
            length, j = nearest_yet, left[at]
            left[at] = left[-1]
            left.pop()
            if taker[j] == -1:
                break
            i = taker[j]
            seen.append(i)
        of_robots[robot] += length
        for other in seen[1:]:
            of_robots[other] += length - reach[taken[other]]
        for place in set(range(n)).difference(left):
            of_places[place] -= length - reach[place]
        while True:
            i = via[j]
            taker[j] = i
            taken[i], j = j, taken[i]
            if i == robot:
                break
    return taken


def _time_for(peak: float, at: float, path: Path) -> float:
    """How long a change takes in which speed times length is at most `peak` [m], so that SHARE is kept [s]."""
    over = 1.0
    for _ in range(20):  # the path may be slower later on: lengthen until it fits
        t = at + over * np.linspace(0.0, 1.0, LOOKOUT)
        step = path.position(t + 0.01) - path.position(t - 0.01)
        speed = max(float(np.hypot(step[:, 0], step[:, 1]).min()) / 0.02, STANDSTILL)
        needed = peak / (SHARE * speed)
        if needed <= over:
            break
        over = needed
    return over
