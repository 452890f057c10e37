"""Reference paths: where the centre of the formation shall be at time t (Table 1 of the paper, and more).

A path is a frozen model, read from the scenario's [path] table by its `kind`, with one method: position(t).
"""

import math
from typing import Annotated, Literal

import numpy as np
from pydantic import Field, FiniteFloat

from formation.arrays import FloatArray
from formation.paths.driven import Driven
from formation.paths.path import Path
from formation.paths.waypoints import Waypoints
from formation.schema import Positive


class Figure8(Path):
    """Reference path 1: a figure eight, x = s sin(2 rate t), y = s sin(rate t)."""

    lengths = ("scale",)
    kind: Literal["figure8"]
    scale: Positive = 1.0
    """s, half its height [m]."""
    rate: Positive = 0.05
    """Of its phase [rad/s]."""

    @property
    def period(self) -> float:
        return 2.0 * math.pi / self.rate

    def position(self, t: FloatArray) -> FloatArray:
        phase = self.rate * t
        return self.scale * np.stack([np.sin(2.0 * phase), np.sin(phase)], axis=-1)


class Circle(Path):
    """Reference path 2: a circle, counter-clockwise from (radius, 0)."""

    lengths = ("radius",)
    kind: Literal["circle"]
    radius: Positive = 0.8
    """Of the circle [m]."""
    rate: Positive = 0.05
    """Of its phase [rad/s]."""

    @property
    def period(self) -> float:
        return 2.0 * math.pi / self.rate

    def position(self, t: FloatArray) -> FloatArray:
        phase = self.rate * t
        return self.radius * np.stack([np.cos(phase), np.sin(phase)], axis=-1)


class Sinusoid(Path):
    """Reference path 3: x = speed t, y = amplitude sin(rate t)."""

    lengths = ("speed", "amplitude")
    kind: Literal["sinusoid"]
    speed: Positive = 0.1
    """Along x [m/s]."""
    amplitude: Positive = 0.8
    """Across x [m]."""
    rate: Positive = 0.1
    """Of its phase [rad/s]."""

    def position(self, t: FloatArray) -> FloatArray:
        return np.stack([self.speed * t, self.amplitude * np.sin(self.rate * t)], axis=-1)


class Spiral(Path):
    """Reference path 4 with erratum 9 mended: growth t (cos(rate t), sin(rate t))."""

    lengths = ("growth",)
    kind: Literal["spiral"]
    growth: Positive = 0.01
    """How fast the radius grows [m/s]."""
    rate: Positive = 0.1
    """Of its phase [rad/s]."""

    def position(self, t: FloatArray) -> FloatArray:
        phase, radius = self.rate * t, self.growth * t
        return np.stack([radius * np.cos(phase), radius * np.sin(phase)], axis=-1)


class Corner(Path):
    """The second test: along y, then at time `at` a sharp turn of 45 degrees to the right."""

    lengths = ("speed",)
    kind: Literal["corner"]
    speed: Positive = 0.1
    """Along y, and after the corner along x as well [m/s]."""
    at: Positive = 20.0
    """When it turns [s]."""

    @property
    def corners(self) -> tuple[tuple[float, float], ...]:
        return ((self.at, -math.pi / 4.0),)

    def position(self, t: FloatArray) -> FloatArray:
        return self.speed * np.stack([np.maximum(t - self.at, 0.0), t], axis=-1)


class Line(Path):
    """A straight line from the origin."""

    lengths = ("speed",)
    kind: Literal["line"]
    speed: Positive = 0.1
    """Along the line [m/s]."""
    heading: FiniteFloat = 0.0
    """Of the line, from x counter-clockwise [rad]."""

    def position(self, t: FloatArray) -> FloatArray:
        return self.speed * np.stack([t * math.cos(self.heading), t * math.sin(self.heading)], axis=-1)


AnyPath = Annotated[
    Figure8 | Circle | Sinusoid | Spiral | Corner | Line | Waypoints | Driven,
    Field(discriminator="kind"),
]
