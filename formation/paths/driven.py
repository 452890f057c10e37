"""A path that somebody drives: speeds are ordered while the run goes on, and robot 1 alone hears the orders."""

import itertools
import math
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field, FiniteFloat, model_validator

from formation.arrays import FloatArray
from formation.paths.path import Path
from formation.schema import Duration, Positive

MAX_COMMANDS = 50_000
"""Orders that a scenario can hold: more than an hour at 10 Hz."""
MAX_SPEED, MAX_TURN = 100.0, 100.0
"""Of an order [m/s, rad/s]; what the robots can do is far less, and orders are cut to it."""

OrderedSpeed = Annotated[FiniteFloat, Field(ge=-MAX_SPEED, le=MAX_SPEED)]
OrderedTurn = Annotated[FiniteFloat, Field(ge=-MAX_TURN, le=MAX_TURN)]


class Driven(Path):
    """Driven by orders of speed and turn rate, from a start pose (docs/theory.md, section 18)."""

    lengths = ("acceleration", "speed")
    kind: Literal["driven"]
    known_to: Literal["all", "leader"] = "leader"
    """Robot 1 alone hears the orders; the others pass its preview on round the ring."""
    start: tuple[FiniteFloat, FiniteFloat, FiniteFloat] = (0.0, 0.0, 0.0)
    """Where the formation's centre stands at t = 0, and which way it heads [m, m, rad]."""
    acceleration: Positive = 0.2
    """How fast the centre's speed follows an order [m/s2]."""
    turn_acceleration: Positive = 1.5
    """How fast its turn rate does [rad/s2]."""
    speed: Positive = 0.1
    """Speed for which a change of shape is timed; it is driven at any [m/s]."""
    commands: Annotated[tuple[tuple[Duration, OrderedSpeed, OrderedTurn], ...], Field(max_length=MAX_COMMANDS)] = ()
    """[[t, v, omega], ...]: orders that the scenario gives by itself, each until the next [s, m/s, rad/s]."""

    @model_validator(mode="after")
    def _in_order(self) -> "Driven":
        if self.known_to != "leader":
            raise ValueError("known_to: expected leader, who alone hears the orders; got all")
        times = [t for t, _, _ in self.commands]
        for index, (before, after) in enumerate(itertools.pairwise(times), start=1):
            if after < before:
                raise ValueError(f"commands[{index}]: expected times in order; got {after:g} s after {before:g} s")
        return self

    @property
    def endless(self) -> bool:
        return True

    def larger(self, by: float) -> dict[str, Any]:
        x, y, theta = self.start
        orders = [(t, by * v, omega) for t, v, omega in self.commands]
        return {**super().larger(by), "start": (by * x, by * y, theta), "commands": orders}

    def position(self, t: FloatArray) -> FloatArray:
        """Straight on at `speed`: what is derived from a path before it is driven. It is driven elsewhere."""
        x, y, theta = self.start
        return np.array([x, y]) + self.speed * np.stack([t * math.cos(theta), t * math.sin(theta)], axis=-1)
