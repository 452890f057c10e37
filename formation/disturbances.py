"""Disturbances of the bodies: a scenario's list of robots that are slowed or pushed, known to the plant only."""

from collections.abc import Sequence
from typing import Annotated

from pydantic import Field, FiniteFloat, model_validator

from formation.schema import Duration, Model, Probability


class Disturbance(Model):
    """For some time, a robot's wheels turn slower than commanded, or the robot is pushed."""

    robot: Annotated[int, Field(ge=1)]
    """Number of the robot, from 1."""
    at: Duration = 0.0
    """Simulated time at which it begins [s]."""
    until: Duration
    """Simulated time at which it ends [s]."""
    drive: Probability = 1.0
    """Share of v and omega that takes effect: 0 is stuck, 0.5 is slowed."""
    drift: tuple[FiniteFloat, FiniteFloat, FiniteFloat] = (0.0, 0.0, 0.0)
    """Velocity with which it is pushed, in the world's frame [m/s, m/s, rad/s]."""

    @model_validator(mode="after")
    def _sensible(self) -> "Disturbance":
        if self.until <= self.at:
            raise ValueError(f"expected until > at; got until {self.until:g} and at {self.at:g}")
        if self.drive == 1.0 and not any(self.drift):
            raise ValueError("expected drive below 1, or a drift")
        return self

    def on(self, now: float) -> bool:
        """Whether it acts on the tick that begins at `now` [s]."""
        return self.at - 1e-9 <= now < self.until - 1e-9


def robots_missing(disturbances: Sequence[Disturbance], robots: int) -> list[str]:
    """A line for each entry that names a robot which the formation does not have."""
    return [
        f"disturbances[{index}].robot: expected 1 to {robots}; got {entry.robot}"
        for index, entry in enumerate(disturbances)
        if entry.robot > robots
    ]
