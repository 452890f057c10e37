"""The [membership] table of a scenario: who leaves the ring and joins it again, and when a lost robot leaves."""

from collections.abc import Iterator
from typing import Annotated, Literal

from pydantic import Field, model_validator

from formation.formation_spec import Formation
from formation.schema import Duration, Model

LEAST = 2
"""Robots that stay in the ring at least."""


class MembershipChange(Model):
    """A robot leaves the ring, and perhaps joins it again; while it is away it stands."""

    robot: Annotated[int, Field(ge=1)]
    """Its number, from 1."""
    leave: Duration
    """Simulated time at which it leaves [s]."""
    join: Duration | None = None
    """Simulated time at which it joins again [s]; with none it stays away."""

    @model_validator(mode="after")
    def _in_order(self) -> "MembershipChange":
        if self.join is not None and self.join <= self.leave:
            raise ValueError(f"expected join > leave; got join {self.join:g} and leave {self.leave:g}")
        return self

    def away(self, now: float) -> bool:
        """Whether the robot is away at a time [s]."""
        return self.leave <= now + 1e-9 and (self.join is None or now + 1e-9 < self.join)


class Membership(Model):
    """The ring closes over a robot that left it: the one downstream of it hears the next one upstream."""

    patience: Duration = 3.0
    """A robot whose agent has been gone for so long leaves, until an agent of it is back; 0: never [s]."""
    shape: Literal["keep", "close"] = "keep"
    """The others keep their places and leave the gap, or take the formation's shape for as many as they are."""
    changes: tuple[MembershipChange, ...] = ()

    def away(self, now: float) -> frozenset[int]:
        """Robots that are away by the scenario at a time [s]."""
        return frozenset(change.robot for change in self.changes if change.away(now))

    def mistakes(self, formation: Formation) -> Iterator[str]:
        """What is wrong with it for this formation."""
        robots = len(formation.array)
        if self.shape == "close" and formation.shape is None:
            yield "membership.shape: expected the name of a shape that fewer robots can take; got formation.offsets"
        for index, change in enumerate(self.changes):
            if change.robot > robots:
                yield f"membership.changes[{index}].robot: expected 1 to {robots}; got {change.robot}"
            elif robots - len(self.away(change.leave)) < LEAST:
                yield (
                    f"membership.changes[{index}]: expected at least {LEAST} robots that stay; at {change.leave:g} s "
                    f"{len(self.away(change.leave))} of {robots} are away"
                )
