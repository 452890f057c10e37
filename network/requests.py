"""What is asked of the world, and what it answers: queries, where network/messages.py has what is published."""

from dataclasses import dataclass, field
from typing import Annotated, Any, Self

import numpy as np
from pydantic import ConfigDict, Field, ValidationError

from formation.arrays import FloatArray
from formation.errors import EchelonError
from formation.faults import Fault
from formation.scenario.user_code import UserCode
from formation.schema import Model
from formation.validation import problems
from network.fields import STRICT, Count, Flag, Link, LongText, NonNegative, Sender, Text
from network.values import Mode


@dataclass(frozen=True, slots=True)
class Setup:
    """World to whoever asks: scenario, mode and faults. An agent that receives a new revision in a tick asks for it."""

    sender: Sender
    seq: Count
    stamp: NonNegative
    episode: Count
    revision: Count
    scenario: LongText
    """JSON of the formation.scenario.Scenario, with the controller in use."""
    mode: Mode
    faults: dict[Link, Fault]  # as in State
    changes: list[dict[str, Any]] = field(default_factory=list)
    """Changes of the shape that users made in this episode: keys of a formation.formation_spec.Change."""
    away: list[Sender] = field(default_factory=list)
    """Robots over which the ring is closed."""
    closed_at: Count = 0
    """Tick from which on that is so: whoever has another neighbour since then begins anew there."""
    user_code: list[UserCode] = field(default_factory=list)  # who has another text of it has no part in the run
    __pydantic_config__ = STRICT


@dataclass(frozen=True, slots=True)
class Request:
    """Client to world: an operation with its arguments; see network/control.py."""

    operation: Text
    arguments: dict[str, Any] = field(default_factory=dict)
    __pydantic_config__ = STRICT


@dataclass(frozen=True, slots=True)
class Reply:
    """World to client: done, or the reason why not."""

    ok: Flag
    reason: Text = ""
    """One line, if not ok."""
    value: dict[str, Any] = field(default_factory=dict)
    __pydantic_config__ = STRICT


Packed = Annotated[bytes, Field(strict=True)]
"""An array, as bytes of little-endian float64."""
Number = Annotated[int, Field(strict=True, ge=0)]


class TraceRows(Model):
    """Rows of an episode of n robots, from a tick on. Those of poses and errors include the start if that tick is 0."""

    model_config = ConfigDict(defer_build=True)

    episode: Number
    robots: Number
    """n."""
    ticks: Number
    """Of the episode so far."""
    last: Number
    """Tick from which on the next rows are."""
    poses: Packed
    """(., n, 3) [m, m, rad]."""
    inputs: Packed
    """(., n, 2) [m/s, rad/s]."""
    ages: Packed
    """(., n) [s]; NaN without an answer."""
    distance: Packed
    """(., n) l_e [m]; NaN while a robot is away."""
    angle: Packed
    """(., n) psi_e [rad]; NaN likewise."""
    tracking: Packed
    """(.,) distance of the robots' mean position to where it should be [m]."""
    centre: Packed
    """(., 2) where the formation's centre should be [m]."""

    @classmethod
    def of(cls, value: Any) -> Self:
        """From a reply's value. Raises EchelonError: it is none."""
        try:
            return cls.model_validate(value)
        except ValidationError as error:
            raise EchelonError("; ".join(problems(error, cls))) from None

    def arrays(self, first: int) -> dict[str, FloatArray]:
        """The arrays by name, if they were asked for from tick `first` on. Raises EchelonError: a size is wrong."""
        n, ticks = self.robots, self.last - first
        rows = ticks + (first == 0)
        if ticks < 0 or (ticks == 0 and self.last < self.ticks):
            raise EchelonError(f"trace: expected rows from tick {first} on; got some up to tick {self.last}")
        shapes: dict[str, tuple[int, ...]] = {
            "poses": (rows, n, 3),
            "inputs": (ticks, n, 2),
            "ages": (ticks, n),
            "distance": (rows, n),
            "angle": (rows, n),
            "tracking": (rows,),
            "centre": (rows, 2),
        }
        return {name: _unpacked(name, getattr(self, name), shape) for name, shape in shapes.items()}


def packed(values: FloatArray) -> bytes:
    """An array as TraceRows has it."""
    return values.astype("<f8").tobytes()


def _unpacked(name: str, data: bytes, shape: tuple[int, ...]) -> FloatArray:
    if len(data) != 8 * int(np.prod(shape)):
        raise EchelonError(f"trace: expected {name} of shape {shape}; got {len(data)} bytes")
    return np.frombuffer(data, dtype="<f8").reshape(shape)
