"""Reference paths: where the centre of the formation shall be at time t (Table 1 of the paper, and more).

A path is a frozen model, read from the scenario's [path] table by its `kind`, with one method: position(t).
"""

import math
from functools import cached_property
from typing import Annotated, Literal

import numpy as np
from pydantic import Field, FiniteFloat, model_validator

from formation.arrays import FloatArray
from formation.paths.spline import Spline, Travel
from formation.schema import Model, Positive


class Path(Model):
    """What every path has."""

    @property
    def period(self) -> float | None:
        """Time after which the path repeats [s]; None for an open path."""
        return None

    @property
    def corners(self) -> tuple[tuple[float, float], ...]:
        """Where its heading jumps: times [s] and turns [rad], counter-clockwise positive."""
        return ()

    def position(self, t: FloatArray) -> FloatArray:
        """Positions at times t [s], of shape t.shape + (2,) [m]. Defined for negative t too."""
        raise NotImplementedError


class Figure8(Path):
    """Reference path 1: a figure eight, x = s sin(2 rate t), y = s sin(rate t)."""

    kind: Literal["figure8"]
    scale: Positive = 1.0
    """s [m]."""
    rate: Positive = 0.05
    """[rad/s]."""

    @property
    def period(self) -> float:
        return 2.0 * math.pi / self.rate

    def position(self, t: FloatArray) -> FloatArray:
        phase = self.rate * t
        return self.scale * np.stack([np.sin(2.0 * phase), np.sin(phase)], axis=-1)


class Circle(Path):
    """Reference path 2: a circle, counter-clockwise from (radius, 0)."""

    kind: Literal["circle"]
    radius: Positive = 0.8
    """[m]."""
    rate: Positive = 0.05
    """[rad/s]."""

    @property
    def period(self) -> float:
        return 2.0 * math.pi / self.rate

    def position(self, t: FloatArray) -> FloatArray:
        phase = self.rate * t
        return self.radius * np.stack([np.cos(phase), np.sin(phase)], axis=-1)


class Sinusoid(Path):
    """Reference path 3: x = speed t, y = amplitude sin(rate t)."""

    kind: Literal["sinusoid"]
    speed: Positive = 0.1
    """[m/s]."""
    amplitude: Positive = 0.8
    """[m]."""
    rate: Positive = 0.1
    """[rad/s]."""

    def position(self, t: FloatArray) -> FloatArray:
        return np.stack([self.speed * t, self.amplitude * np.sin(self.rate * t)], axis=-1)


class Spiral(Path):
    """Reference path 4 with erratum 9 mended: growth t (cos(rate t), sin(rate t))."""

    kind: Literal["spiral"]
    growth: Positive = 0.01
    """[m/s]."""
    rate: Positive = 0.1
    """[rad/s]."""

    def position(self, t: FloatArray) -> FloatArray:
        phase, radius = self.rate * t, self.growth * t
        return np.stack([radius * np.cos(phase), radius * np.sin(phase)], axis=-1)


class Corner(Path):
    """The second test: along y, then at time `at` a sharp turn of 45 degrees to the right."""

    kind: Literal["corner"]
    speed: Positive = 0.1
    """Along y, and after the corner along x as well [m/s]."""
    at: Positive = 20.0
    """[s]."""

    @property
    def corners(self) -> tuple[tuple[float, float], ...]:
        return ((self.at, -math.pi / 4.0),)

    def position(self, t: FloatArray) -> FloatArray:
        return self.speed * np.stack([np.maximum(t - self.at, 0.0), t], axis=-1)


class Line(Path):
    """A straight line from the origin."""

    kind: Literal["line"]
    speed: Positive = 0.1
    """[m/s]."""
    heading: FiniteFloat = 0.0
    """[rad]."""

    def position(self, t: FloatArray) -> FloatArray:
        return self.speed * np.stack([t * math.cos(self.heading), t * math.sin(self.heading)], axis=-1)


class Waypoints(Path):
    """A smooth curve (C2 spline) through points, travelled at constant speed; straight on past an open end."""

    kind: Literal["waypoints"]
    points: Annotated[list[tuple[FiniteFloat, FiniteFloat]], Field(min_length=2, max_length=1000)]
    """[m]."""
    speed: Positive = 0.1
    """[m/s]."""
    closed: bool = False
    """Whether the curve returns to the first point."""

    @model_validator(mode="after")
    def _distinct(self) -> "Waypoints":
        gaps = np.diff(np.array([*self.points, *self.points[:1]][: None if self.closed else -1]), axis=0)
        if not np.all(np.hypot(gaps[:, 0], gaps[:, 1]) > 0.0):
            raise ValueError("expected points that differ from their neighbours")
        if self.closed and len(self.points) < 3:
            raise ValueError("expected at least 3 points for a closed curve")
        return self

    @cached_property
    def _curve(self) -> Travel:
        return Spline.through(np.array(self.points), closed=self.closed).by_arc_length()

    @property
    def period(self) -> float | None:
        return self._curve.length / self.speed if self.closed else None

    def position(self, t: FloatArray) -> FloatArray:
        return self._curve(self.speed * t)


AnyPath = Annotated[Figure8 | Circle | Sinusoid | Spiral | Corner | Line | Waypoints, Field(discriminator="kind")]


def heading(path: Path, t: FloatArray, interval: float) -> FloatArray:
    """Heading of the path as the paper samples it (below eq. 2): the direction of the last interval.

    theta_r(t) = atan2(p_r(t) - p_r(t - interval)) [rad], of the shape of t.
    """
    step = path.position(t) - path.position(t - interval)
    return np.arctan2(step[..., 1], step[..., 0])
