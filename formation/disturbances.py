"""Disturbances of the bodies: robots that are slowed, pushed, on slippery ground, or not localised.

A scenario lists them, and users of a live run add them (`Push`, `displacement`); the plant alone knows them.
"""

from collections.abc import Sequence
from typing import Annotated, Literal, NamedTuple

from pydantic import Field, FiniteFloat, model_validator

from formation.schema import Duration, Model, NonNegative, Probability


class Disturbance(Model):
    """For some time, a robot's wheels turn slower than commanded or slip, it is pushed, or it is not localised."""

    robot: Annotated[int, Field(ge=1)]
    """Number of the robot, from 1."""
    at: Duration = 0.0
    """Simulated time at which it begins [s]."""
    until: Duration | None = None
    """Simulated time at which it ends [s]; with none it lasts."""
    drive: Probability = 1.0
    """Share of v and omega that takes effect: 0 is stuck, 0.5 is slowed."""
    speed: NonNegative | None = None
    """The wheels turn at most so fast [m/s]; odometry knows it."""
    drift: tuple[FiniteFloat, FiniteFloat, FiniteFloat] = (0.0, 0.0, 0.0)
    """Velocity with which it is pushed, in the world's frame [m/s, m/s, rad/s]."""
    slip: NonNegative = 0.0
    """Added to the standard deviation of the wheels' slip, as a share of v and of omega [1]."""
    blind: bool = False
    """Whether localisation does not deliver."""

    @model_validator(mode="after")
    def _sensible(self) -> "Disturbance":
        if self.until is not None and self.until <= self.at:
            raise ValueError(f"expected until > at; got until {self.until:g} and at {self.at:g}")
        if not self.words:
            raise ValueError("expected drive below 1, a speed, a drift, slip, or blind")
        return self

    def on(self, now: float) -> bool:
        """Whether it acts on the tick that begins at `now` [s]."""
        return self.at - 1e-9 <= now and (self.until is None or now < self.until - 1e-9)

    @property
    def words(self) -> str:
        """What it does, in a few words."""
        x, y, turn = self.drift
        found = [
            "stuck" if self.drive == 0.0 else f"slowed to {self.drive:.0%}" if self.drive < 1.0 else "",
            "" if self.speed is None else f"at most {self.speed:.3g} m/s",
            f"pushed at ({x:.3g}, {y:.3g}) m/s" if x or y else "",
            f"turned at {turn:.3g} rad/s" if turn else "",
            f"slips by {self.slip:.0%}" if self.slip else "",
            "not localised" if self.blind else "",
        ]
        return ", ".join(text for text in found if text)


class Push(NamedTuple):
    """A disturbance that users order by a name."""

    help: str
    """One line for tables and hints."""
    keys: dict[str, float | bool | tuple[float, float, float]]
    """Of a Disturbance."""


Kind = Literal["gust", "slow", "stuck", "slippery", "blind"]
PUSHES: dict[Kind, Push] = {
    "gust": Push("carried along y at 0.05 m/s", {"drift": (0.0, 0.05, 0.0)}),
    "slow": Push("its wheels make half of their speed", {"drive": 0.5}),
    "stuck": Push("it does not move, whatever its wheels do", {"drive": 0.0}),
    "slippery": Push("a third of the motion is lost, and slip varies by half", {"drive": 0.67, "slip": 0.5}),
    "blind": Push("localisation does not deliver", {"blind": True}),
}
DISPLACED_SECONDS = 0.5
"""A robot that is moved aside is carried there within so long [s]."""
FARTHEST = 1.0
"""Of a displacement [m]."""


def pushed(robot: int, kind: Kind, now: float, seconds: float | None) -> Disturbance:
    """The disturbance of this name from `now` on, for so long or until it is cleared [s]."""
    until = None if seconds is None else now + seconds
    return Disturbance.model_validate({"robot": robot, "at": now, "until": until, **PUSHES[kind].keys})


def displacement(robot: int, dx: float, dy: float, now: float, tick: float) -> Disturbance:
    """Carries the robot by (dx, dy) [m] in whole ticks [s] from `now` on."""
    ticks = max(1, round(DISPLACED_SECONDS / tick))
    lasts = ticks * tick
    return Disturbance(robot=robot, at=now, until=now + lasts, drift=(dx / lasts, dy / lasts, 0.0))


def robots_missing(disturbances: Sequence[Disturbance], robots: int) -> list[str]:
    """A line for each entry that names a robot which the formation does not have."""
    return [
        f"disturbances[{index}].robot: expected 1 to {robots}; got {entry.robot}"
        for index, entry in enumerate(disturbances)
        if entry.robot > robots
    ]
