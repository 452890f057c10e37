"""The scenario's [bodies] table: how wheels follow commands, what sensors see, and what differs from robot to robot.

docs/theory.md, section 11, has the equations. Numbers that are drawn per robot are uniform within +- the bound.
"""

from typing import Annotated, Any, Literal

from pydantic import Field, FiniteFloat, model_validator

from formation.bodies.presets import PRESETS
from formation.errors import unknown
from formation.schema import Duration, Model, NonNegative, Positive, Probability

RADIUS = 0.035
"""Of a body whose radius nobody gives: an e-puck's [m]."""


class Dropout(Model):
    """For a while, a robot's localisation sees nothing."""

    robot: Annotated[int, Field(ge=1)]
    """Number of the robot, from 1."""
    at: Duration = 0.0
    """Simulated time at which it begins [s]; a measurement is lost if its stamp lies within at .. until."""
    until: Duration
    """Simulated time at which it ends [s]."""


class Localisation(Model):
    """What tells a robot where it is."""

    rate: Positive | None = None
    """Measurements a second; if absent, one a tick; a whole number of ticks lies between two [1/s]."""
    age: Duration = 0.0
    """From the moment that is measured to its arrival [s]."""
    position: NonNegative = 0.0
    """Standard deviation of x and y [m]."""
    heading: NonNegative = 0.0
    """Standard deviation of the heading [rad]."""
    outliers: Probability = 0.0
    """Share of measurements that are far off."""
    outlier_size: NonNegative = 0.05
    """Standard deviation of x and y that an outlier adds [m]; to the heading it adds 0.25 rad."""
    dropouts: tuple[Dropout, ...] = ()
    """When a robot's localisation sees nothing."""


class RelativeSensing(Model):
    """A sensor of the upstream neighbour's position in the own frame."""

    sigma: Annotated[FiniteFloat, Field(ge=0.0)] | None = None
    """Standard deviation of x and y [m]; without a value robots do not see each other."""


class Gusts(Model):
    """Pushes that come and go by chance, alone or together."""

    sigma: NonNegative = 0.0
    """Standard deviation of the velocity with which a robot is carried, along x and along y [m/s]."""
    time: Annotated[Duration, Field(gt=0.0)] = 2.0
    """Correlation time [s]."""
    correlation: Probability = 0.0
    """Of any two robots' gusts: 0, each has its own; 1, all are carried alike."""


class BodyLimits(Model):
    """What a body can do: |v| <= v, |omega| <= omega."""

    v: Positive = 0.5
    """Largest |v| [m/s]."""
    omega: Positive = 2.0
    """Largest |omega| [rad/s]."""


class RobotBody(Model):
    """What differs in one robot; a key that is absent is that of all."""

    robot: Annotated[int, Field(ge=1)]
    """Number of the robot, from 1."""
    lag: Duration | None = None
    """Time constant with which its wheel speeds follow commands [s]."""
    acceleration: Positive | None = None
    """Its largest change of v [m/s2]."""
    turn_acceleration: Positive | None = None
    """Its largest change of omega [rad/s2]."""
    scale: FiniteFloat | None = None
    """Its own s_v, instead of a drawn one: it drives 1 + s_v times as fast as its wheels say [1]."""
    turn_scale: FiniteFloat | None = None
    """Its own s_omega, likewise [1]."""
    turn_offset: FiniteFloat | None = None
    """Its own b_omega, instead of a drawn one: it turns so fast by itself [rad/s]."""
    slip: NonNegative | None = None
    """Its slip, as of bodies.slip [1]."""
    gyro: NonNegative | None = None
    """Its error of omega, as of bodies.gyro [rad/s]."""
    radius: Positive | None = None
    """Its radius [m]."""
    limits: BodyLimits | None = None
    """What it can do."""


class Bodies(Model):
    """The bodies of all robots."""

    preset: Annotated[str, Field(json_schema_extra={"enum": list(PRESETS)})] = "ideal"
    """A named set of values for the keys below; keys beside it refine it."""
    implementation: str = "wheeled"
    """Which model moves the bodies (world/bodies/)."""
    lag: Duration = 0.0
    """Time constant with which wheel speeds follow commands [s]."""
    acceleration: Positive | None = None
    """Largest change of v [m/s2]; unlimited if absent."""
    turn_acceleration: Positive | None = None
    """Largest change of omega [rad/s2]; unlimited if absent."""
    delay: Duration = 0.0
    """From a command's arrival to its effect, at most 1000 ticks [s]."""
    scale: NonNegative = 0.0
    """Bound of s_v: a robot drives 1 + s_v times as fast as its wheels say [1]."""
    turn_scale: NonNegative = 0.0
    """Bound of s_omega, likewise [1]."""
    turn_offset: NonNegative = 0.0
    """Bound of b_omega: a robot turns so fast by itself [rad/s]."""
    slip: NonNegative = 0.0
    """Each tick v and omega are multiplied by 1 + slip n, each with its own n, standard normal [1]."""
    gyro: NonNegative = 0.0
    """Each tick gyro n is added to omega [rad/s]."""
    slip_time: Duration = 0.0
    """Correlation time of slip and gyro [s]; 0 is white noise."""
    radius: Positive = RADIUS
    """Two bodies touch when their centres are closer than the sum of their radii [m]."""
    arena: tuple[FiniteFloat, FiniteFloat, FiniteFloat, FiniteFloat] | None = None
    """[x_min, y_min, x_max, y_max] that robots must not leave [m]; only counted."""
    limits: BodyLimits | None = None
    """What the robots can do; stands for those keys of robots.limits that are not given."""
    fit: Literal["scale", "refuse"] = "scale"
    """What to do with a formation that is too narrow for a preset's robots (formation/scenario/fitting.py)."""
    scaled: Positive = 1.0
    """By which factor the scenario's lengths have been multiplied so that the robots fit [1]."""
    localisation: Localisation = Localisation()
    relative: RelativeSensing = RelativeSensing()
    gusts: Gusts = Gusts()
    robots: tuple[RobotBody, ...] = ()
    """What differs from robot to robot."""

    @model_validator(mode="before")
    @classmethod
    def _with_preset(cls, raw: Any) -> Any:
        """Short text is a preset's name, or "mujoco:" and one; its values stand for the keys that are not given."""
        if isinstance(raw, str):
            implementation, _, preset = raw.rpartition(":")
            raw = {"preset": preset} | ({"implementation": implementation} if implementation else {})
        if not isinstance(raw, dict):
            return raw
        name = raw.get("preset", "ideal")
        if name not in PRESETS:
            raise ValueError(unknown("preset", str(name), PRESETS))
        return _merged(PRESETS[name], raw)

    @model_validator(mode="after")
    def _sensible(self) -> "Bodies":
        seen = [entry.robot for entry in self.robots]
        if len(set(seen)) < len(seen):
            raise ValueError("robots: expected at most one entry a robot")
        if self.arena and not (self.arena[0] < self.arena[2] and self.arena[1] < self.arena[3]):
            raise ValueError("arena: expected [x_min, y_min, x_max, y_max]")
        return self

    def of(self, robot: int) -> RobotBody:
        """What differs in this robot."""
        return next((entry for entry in self.robots if entry.robot == robot), RobotBody(robot=robot))

    def radii(self, robots: int) -> list[float]:
        """Of robots 1 to this one [m]."""
        own = {entry.robot: entry.radius for entry in self.robots}
        return [own.get(robot) or self.radius for robot in range(1, robots + 1)]

    def width(self, robots: int) -> float:
        """Of the widest of so many robots [m]."""
        return 2.0 * max(self.radii(robots))

    @property
    def footprint(self) -> bool:
        """Whether the preset is a robot of a known size."""
        return "radius" in PRESETS[self.preset]

    @property
    def sees(self) -> bool:
        """Whether robots sense their upstream neighbour's position."""
        return self.relative.sigma is not None


def _merged(below: Any, above: Any) -> Any:
    """A preset's table with the given keys on top."""
    if not (isinstance(below, dict) and isinstance(above, dict)):
        return above
    return {**below, **{key: _merged(below.get(key), value) for key, value in above.items()}}
