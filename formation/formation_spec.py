"""The formation of a scenario: the shape it starts in, those it changes to, and which way it faces."""

from functools import cached_property
from typing import Annotated, Literal

import numpy as np
from pydantic import Field, FiniteFloat, model_validator

from formation.arrays import FloatArray, frozen
from formation.metrics import nearest
from formation.paths.files import PointFile
from formation.schema import MAX_ROBOTS, Duration, Positive
from formation.shapes import FIXED_SIZES, SHAPES

MAX_CHANGES = 100
SAME_PLACE = 1e-3
"""Robots that are nearer to each other than this share of the formation's extent stand in the same place."""


class Shape(PointFile):
    """Where the robots stand in the body frame: by the name of a shape, by offsets, or by a file of them."""

    shape: Literal["line", "column", "triangle", "square", "polygon", "wedge"] | None = None
    """The name of the shape."""
    spacing: Positive = 0.1
    """Distance between neighbours [m]."""
    robots: Annotated[int, Field(ge=2, le=MAX_ROBOTS)] | None = None
    """How many, where the shape's name leaves that open."""
    offsets: Annotated[list[tuple[FiniteFloat, FiniteFloat]], Field(min_length=2, max_length=MAX_ROBOTS)] | None = None
    """[[x, y], ...], x forward and y left [m]; their mean becomes zero."""

    @model_validator(mode="after")
    def _one_way(self) -> "Shape":
        if (self.shape is None) == (self.offsets is None):
            raise ValueError("expected either shape or offsets")
        if self.offsets is not None and self.robots not in (None, len(self.offsets)):
            raise ValueError(f"expected as many offsets as robots; got {len(self.offsets)} and {self.robots}")
        fixed = FIXED_SIZES.get(self.shape or "")
        if fixed is not None and self.robots not in (None, fixed):
            raise ValueError(f"expected {fixed} robots for the shape {self.shape}; got {self.robots}")
        return self

    def array_for(self, robots: int) -> FloatArray:
        """Offsets (n, 2) with mean zero [m] of so many robots.

        Raises:
            ValueError: this shape has another number of them, or two of them stand in the same place.
        """
        if self.offsets is not None:
            given = np.array(self.offsets)
            array = given - given.mean(axis=0)
        else:
            assert self.shape is not None
            array = SHAPES[self.shape](FIXED_SIZES.get(self.shape, robots), self.spacing)
        if len(array) != robots:
            raise ValueError(f"expected a shape for {robots} robots; got one for {len(array)}")
        one, other, apart = nearest(array)
        if apart <= SAME_PLACE * float(np.ptp(array, axis=0).max()):
            raise ValueError(
                f"expected a place for each robot, but the offsets of robots {one} and {other} do not differ: "
                f"they are {apart:.3g} m apart"
            )
        return frozen(array)


class Change(Shape):
    """The formation takes another shape or spacing during the episode (time-varying patterns: section 2.1)."""

    at: Duration
    """Simulated time at which it begins [s]."""
    over: Annotated[Duration, Field(gt=0.0)] | None = None
    """How long it takes [s]; if absent, so long that no slot moves faster within the formation than half the
    speed of the path (formation/offsets.py)."""
    reassign: bool = True
    """Assign the slots so that the sum of squared distances is least; else row i is robot i's."""
    without: tuple[Annotated[int, Field(ge=1, le=MAX_ROBOTS)], ...] = ()
    """Robots that have no place in it, because they have left the ring; theirs stays what it was."""
    named: str | None = None
    """The shape that the offsets are of, where a user ordered it by name."""

    def array_for(self, robots: int) -> FloatArray:
        """Offsets of the robots that have a place in it, in the order of their numbers; see Shape."""
        return super().array_for(robots - len(self.without))

    def members(self, robots: int) -> list[int]:
        """Rows of the robots that have a place in it, of so many."""
        return [row for row in range(robots) if row + 1 not in self.without]


class Formation(Shape):
    """The shape at the start, its orientation, and its changes."""

    orientation: Literal["path", "fixed", "limited"] = "path"
    """Along the path, always the same, or along the path but turning at a limited rate."""
    heading: FiniteFloat = 0.0
    """Heading of a formation with orientation `fixed` [rad]."""
    turn_rate: Positive | None = None
    """How fast a limited formation turns [rad/s]; if absent, so fast that its rotation moves no slot faster than
    a small share of the path's speed (formation/orientation.py)."""
    changes: Annotated[tuple[Change, ...], Field(max_length=MAX_CHANGES)] = ()
    """Shapes that it takes later, in the order of their times."""

    @model_validator(mode="after")
    def _sized(self) -> "Formation":
        if self.shape is not None and self.shape not in FIXED_SIZES and self.robots is None:
            raise ValueError(f"expected robots = n for the shape {self.shape}")
        size = len(self.array)
        for index, change in enumerate(self.changes):
            if index and change.at < self.changes[index - 1].at:
                raise ValueError("expected changes in the order of their times")
            try:
                change.array_for(size)
            except ValueError as error:
                raise ValueError(f"changes[{index}]: {error}") from None
        return self

    @property
    def shapes(self) -> list[FloatArray]:
        """Offsets (n, 2) of the shape at the start and of those that it changes to [m]."""
        return [self.array, *(change.array_for(len(self.array)) for change in self.changes)]

    @cached_property
    def array(self) -> FloatArray:
        """Offsets (n, 2) at the start, with mean zero [m]."""
        if self.offsets is not None:
            return self.array_for(len(self.offsets))
        return self.array_for(self.robots or FIXED_SIZES[self.shape or ""])
