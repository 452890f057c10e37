"""The operations on the robots of a run, one model each; network/control.py has them among the others."""

from typing import Annotated, Literal

from pydantic import ConfigDict, Field, FiniteFloat

from formation.disturbances import FARTHEST, Kind
from formation.schema import MAX_ROBOTS, Duration, Model, Positive

MAX_SECONDS = 1e6
"""Of an order [s]."""
Robot = Annotated[int, Field(strict=True, ge=1, le=MAX_ROBOTS)]


class OperationModel(Model):
    """A request to the world, or a value of a reply. Its validator is made when the first one comes in."""

    model_config = ConfigDict(defer_build=True)


class Push(OperationModel):
    """Disturb a robot's body from the next tick on."""

    robot: Robot
    kind: Kind
    """Of formation.disturbances.PUSHES."""
    seconds: Annotated[Duration, Field(gt=0.0, le=MAX_SECONDS)] | None = None
    """Simulated time after which it ends; None: until `Release` or a reset."""


class Move(OperationModel):
    """Take a robot and carry it aside, within half a second from the next tick on."""

    robot: Robot
    dx: Annotated[FiniteFloat, Field(ge=-FARTHEST, le=FARTHEST)]
    """In the world's frame [m]."""
    dy: Annotated[FiniteFloat, Field(ge=-FARTHEST, le=FARTHEST)]
    """In the world's frame [m]."""


class Release(OperationModel):
    """End every disturbance that acts on a robot now, scheduled or not."""

    robot: Robot | None = None
    """None: of all robots."""


class Leave(OperationModel):
    """Take a robot out of the ring, which closes over it; it stands until `Join` or a reset."""

    robot: Robot


class Join(OperationModel):
    """Take a robot that a user took out of the ring into it again."""

    robot: Robot


class Reshape(OperationModel):
    """Change the shape, the spacing, or both, from the next tick on; a reset returns to the scenario's."""

    shape: Literal["line", "column", "triangle", "square", "polygon", "wedge"] | None = None
    spacing: Annotated[Positive, Field(le=100.0)] | None = None
    """Between neighbours [m]."""
    over: Annotated[Duration, Field(gt=0.0, le=MAX_SECONDS)] | None = None
    """How long the change takes [s]; derived from the path's speed, if None."""
