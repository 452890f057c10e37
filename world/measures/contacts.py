"""Contacts and clearance of the bodies, commands at a limit or changed to keep off, and robots outside the arena."""

import math
from collections.abc import Mapping, Sequence
from itertools import combinations
from typing import Any

import numpy as np

from formation.arrays import FloatArray, IntArray
from formation.metrics import near
from formation.scenario.scenario import Scenario
from network.messages import Command

RELEASE = 0.002
"""Two bodies that touch have to part by so much before they can come to touch again [m]: noise is not a contact."""
FEW, CROWD = 12, 64
"""So few bodies are compared one by one; of more than so many, only those that are near each other."""
AT_LIMIT = 1e-9
"""A command so close to a limit stands at it [m/s, rad/s]."""
QUIET_SECONDS = 1.0
"""A robot that did not have to keep off anybody for so long begins to anew [s]."""


class Contacts:
    """Which bodies touch: those whose centres are closer than the sum of their radii."""

    def __init__(self, radii: Sequence[float]) -> None:
        """Nothing so far; radii (n,) of at least two bodies [m]."""
        self._radii = np.array(radii)
        self._n = len(self._radii)
        self._widest = 2.0 * float(self._radii.max())
        self._pairs = np.triu_indices(self._n, k=1) if self._n <= CROWD else None
        sums = self._sums(*self._pairs) if self._pairs else 2.0 * self._radii
        self._alike = float(sums[0]) if np.all(sums == sums[0]) else None
        self._touching: set[int] = set()
        """Pairs of rows i, j as i n + j."""
        self._tightest = 0, 1
        """Rows of the pair that had the least gap."""
        self.count = 0
        """Pairs that came to touch, so far."""
        self.clearance = np.inf
        """Least distance of two centres so far [m]."""
        self.gap = np.inf
        """Least distance of two bodies so far [m]; negative if they overlapped."""

    def look(self, poses: FloatArray) -> list[tuple[int, int]]:
        """The bodies are at poses (n, 3); pairs (numbers, from 1) that have come to touch."""
        if self._alike is not None and not self._touching and self._n <= CROWD:
            nearest = self._nearest(poses)
            gap = nearest - self._alike
            if gap >= RELEASE:
                if nearest < self.clearance:
                    self.clearance, self.gap = nearest, gap
                return []
        one, other = self._pairs or self._near(poses)
        distance = np.sqrt(_squares(poses, one, other))
        gaps = distance - self._sums(one, other)
        least = int(gaps.argmin())
        self._tightest = int(one[least]), int(other[least])
        self.clearance, self.gap = min(self.clearance, float(distance.min())), min(self.gap, float(gaps[least]))
        close, before = np.flatnonzero(gaps < RELEASE), self._touching
        found = zip((one[close] * self._n + other[close]).tolist(), gaps[close].tolist(), strict=True)
        self._touching = {pair for pair, gap in found if gap < 0.0 or pair in before}
        new = sorted(self._touching - before)
        self.count += len(new)
        return [(pair // self._n + 1, pair % self._n + 1) for pair in new]

    def _near(self, poses: FloatArray) -> tuple[IntArray, IntArray]:
        """Of many bodies: rows of all pairs that may touch, or have the least distance or gap of all."""
        one, other = np.array([self._tightest[0]]), np.array([self._tightest[1]])
        bound = math.sqrt(_squares(poses, one, other)[0]) - self._sums(one, other)[0]
        return near(poses, self._widest + max(bound, RELEASE))

    def _sums(self, one: IntArray, other: IntArray) -> FloatArray:
        sums: FloatArray = self._radii[one] + self._radii[other]
        return sums

    def _nearest(self, poses: FloatArray) -> float:
        """Least distance of two centres [m]; of few bodies by Python's arithmetic: faster, and the same bits."""
        if len(poses) > FEW:
            assert self._pairs is not None
            return math.sqrt(_squares(poses, *self._pairs).min())
        least = math.inf
        for (x, y, _), (u, v, _) in combinations(poses.tolist(), 2):
            square = (x - u) * (x - u) + (y - v) * (y - v)
            least = square if square < least else least
        return math.sqrt(least)

    def summary(self) -> dict[str, Any]:
        """For the summary of the episode."""
        return {"contacts": self.count, "clearance_m": self.clearance, "gap_m": self.gap}


def _squares(poses: FloatArray, one: IntArray, other: IntArray) -> FloatArray:
    """Squared distances of pairs of rows [m2]."""
    places = poses.T[:2].copy()
    apart = places.take(one, axis=1)
    apart -= places.take(other, axis=1)
    apart *= apart
    squares: FloatArray = apart[0] + apart[1]
    return squares


class AtLimits:
    """For how long each robot stood at a limit, kept off others, and was outside the arena."""

    def __init__(self, scenario: Scenario) -> None:
        robots = range(1, scenario.size + 1)
        limits = [_limits(scenario, robot) for robot in robots]
        self._limits = [(v - AT_LIMIT, omega - AT_LIMIT) for v, omega in limits]
        self._arena, self._dt = scenario.bodies.arena, scenario.control_interval
        self._at_limit, self._outside, self._kept_off = ([0] * scenario.size for _ in range(3))
        self._kept_at = [-math.inf] * scenario.size

    def reports(self, commands: Mapping[int, Command], now: float) -> list[str]:
        """Count the changed commands of a tick; which robot begins to keep off which."""
        begun = []
        for robot, command in commands.items():
            if command.keeps_off:
                if now - self._kept_at[robot - 1] > QUIET_SECONDS:
                    begun.append(f"robot {robot} keeps off robot {command.keeps_off}")
                self._kept_at[robot - 1] = now
                self._kept_off[robot - 1] += 1
        return begun

    def add(self, inputs: Sequence[tuple[float, float]], poses: FloatArray) -> None:
        """A tick: the commanded inputs of all robots [m/s, rad/s], the poses (n, 3) after it."""
        for row, ((v, omega), (v_most, omega_most)) in enumerate(zip(inputs, self._limits, strict=True)):
            if abs(v) >= v_most or abs(omega) >= omega_most:
                self._at_limit[row] += 1
        if self._arena is not None:
            left, low, right, high = self._arena
            for row, (x, y, _) in enumerate(poses.tolist()):
                if x < left or x > right or y < low or y > high:
                    self._outside[row] += 1

    def summary(self, robot: int) -> dict[str, Any]:
        """Of one robot, for the summary of the episode [s]; None for the arena if there is none."""
        counts = (self._at_limit, self._kept_off, self._outside)
        at_limit, kept_off, outside = (ticks[robot - 1] * self._dt for ticks in counts)
        return {"limit_s": at_limit, "kept_off_s": kept_off, "left_arena_s": None if self._arena is None else outside}


def _limits(scenario: Scenario, robot: int) -> tuple[float, float]:
    """Of one robot's commands: those of its body, or of all robots, whichever are lower [m/s, rad/s]."""
    of_all, own = scenario.robots.limits, scenario.bodies.of(robot).limits
    return (of_all.v, of_all.omega) if own is None else (min(own.v, of_all.v), min(own.omega, of_all.omega))
