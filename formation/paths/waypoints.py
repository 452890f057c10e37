"""A path through points: a smooth curve, travelled at constant speed or at a speed for each point."""

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Annotated, Literal

import numpy as np
from pydantic import Field, FiniteFloat, model_validator

from formation.arrays import FloatArray
from formation.paths.files import Column, PointFile
from formation.paths.path import Path
from formation.paths.smoothing import smoothed
from formation.paths.spline import Spline, Travel
from formation.schema import NonNegative, Positive

MAX_POINTS = 100_000
SAME = 1e-6
"""Neighbours that are nearer to one another than this share of the way through all points are one point."""


@dataclass(frozen=True, slots=True)
class Course:
    """The points that a path goes through, once what repeats is left out and the rest is smoothed."""

    points: FloatArray
    """(M, 2) [m]; of a closed path the first is not given again at the end."""
    numbers: FloatArray
    """(M,) which of the given points each is, from 0."""
    travel: Travel


class Waypoints(Path, PointFile):
    """A smooth curve (C2 spline) through points, travelled at constant speed; straight on past an open end.

    Neighbouring points that repeat are one point, and so are the ends of a closed path.
    """

    lengths = ("points", "speed", "speeds", "smoothing", "least_distance")
    kind: Literal["waypoints"]
    points: Annotated[list[tuple[FiniteFloat, FiniteFloat]], Field(min_length=2, max_length=MAX_POINTS)]
    """[[x, y], ...] [m], or from a `file`."""
    speed: Positive = 0.1
    """Along the path [m/s]."""
    speed_column: Column | None = None
    """Which column of the `file` holds the speed at each point, in its `unit` a second: its name or number."""
    speeds: list[NonNegative] | None = None
    """At each point, changing at a constant rate in between; instead of `speed` [m/s]."""
    closed: bool = False
    """Whether the curve returns to the first point."""
    smoothing: NonNegative = 0.0
    """The curve may pass each point at this distance, to bend as little as it can [m]."""
    least_distance: NonNegative = 0.0
    """Points that are nearer than this to the one before are left out [m]."""

    @model_validator(mode="after")
    def _curved(self) -> "Waypoints":
        if self.speeds is not None:
            self._check_speeds(self.speeds)
        least = 3 if self.closed else 2
        if len(self._kept) < least:
            raise ValueError(
                f"expected at least {least} points that differ{' for a closed path' * self.closed}; "
                f"got {len(self._kept)}"
            )
        return self

    def _check_speeds(self, speeds: list[float]) -> None:
        if len(speeds) != len(self.points):
            raise ValueError(f"expected as many speeds as points; got {len(speeds)} and {len(self.points)}")
        standing = np.array(speeds)[self._kept] <= 0.0
        stuck = standing & np.roll(standing, -1)
        if not self.closed:
            stuck[-1] = standing[-1]  # from there on it would never move again
        if stuck.any():
            index = int(self._kept[int(stuck.argmax())])
            raise ValueError(f"speeds[{index}]: expected more than 0 here or at the next point; got 0 at both")

    @cached_property
    def _kept(self) -> FloatArray:
        """(M,) indices of the points that count."""
        given = np.array(self.points, dtype=float).reshape(-1, 2)
        length = float(np.hypot(*np.diff(given, axis=0).T).sum())
        least = max(SAME * length, self.least_distance)
        kept = [0]
        for index, (x, y) in enumerate(self.points):
            before = self.points[kept[-1]]
            if math.hypot(x - before[0], y - before[1]) > least:
                kept.append(index)
        while self.closed and len(kept) > 1 and np.hypot(*(given[kept[-1]] - given[0])) <= least:
            kept.pop()
        return np.array(kept)

    @cached_property
    def course(self) -> Course:
        """What the path goes through."""
        points = smoothed(np.array(self.points, dtype=float)[self._kept], self.smoothing, closed=self.closed)
        return Course(points, self._kept, Spline.through(points, closed=self.closed).by_arc_length())

    @cached_property
    def _timing(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Times (M,) [s], ways (M,) [m] and speeds (M,) [m/s] at the knots of the curve."""
        travel = self.course.travel
        given = np.full(len(self.points), self.speed) if self.speeds is None else np.array(self.speeds)
        speeds = given[self._kept]
        if self.closed:
            speeds = np.append(speeds, speeds[0])
        ways = travel.at_knots
        times = np.concatenate([[0.0], np.cumsum(2.0 * np.diff(ways) / (speeds[1:] + speeds[:-1]))])
        return times, ways, speeds

    @property
    def smooth(self) -> bool:
        return False

    @property
    def period(self) -> float | None:
        if not self.closed:
            return None
        return self.course.travel.length / self.speed if self.speeds is None else float(self._timing[0][-1])

    def position(self, t: FloatArray) -> FloatArray:
        return self.course.travel(self.way(t))

    def way(self, t: FloatArray) -> FloatArray:
        """How far along the path it is at times t, of the shape of t [m]."""
        if self.speeds is None:
            return self.speed * t
        times, ways, speeds = self._timing
        inside = np.mod(t, times[-1]) if self.closed else np.clip(t, 0.0, times[-1])
        i = np.clip(np.searchsorted(times, inside, side="right") - 1, 0, len(times) - 2)
        since, gain = inside - times[i], (speeds[i + 1] - speeds[i]) / (times[i + 1] - times[i])
        beyond = (t - inside) * np.where(t < 0.0, speeds[0], speeds[-1])
        found: FloatArray = ways[i] + since * (speeds[i] + 0.5 * gain * since)
        return found if self.closed else found + beyond
