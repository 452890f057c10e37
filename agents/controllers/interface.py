"""The interface of a controller: its observation at a planning tick, and its solution.

They are NamedTuples: a frozen dataclass takes four times as long to make, and there are four a plan.
"""

import math
from typing import NamedTuple, Protocol, TypeVar

import numpy as np

from formation.arrays import FloatArray, frozen
from formation.scenario.controllers import ControllerOptions
from formation.scenario.scenario import Scenario
from network.messages import Plan
from network.values import NO_NEWS, STILL, Motion

NONE: FloatArray = frozen(np.zeros(3))
CERTAIN: FloatArray = frozen(np.zeros((3, 3)))
NOBODY: FloatArray = frozen(np.zeros((0, 6)))


class NeighborEstimate(NamedTuple):
    """A neighbour in the ring where the horizon begins."""

    pose: FloatArray
    """(3,) [m, m, rad]."""
    inputs: FloatArray
    """(N, 2) mean body velocities from there on [m/s, rad/s]."""
    plan: Plan | None
    """The message behind it; None before the first."""
    age: float = math.inf
    """Since that plan began [s], at least 0; inf without one, or when it has ended."""
    drift: FloatArray = STILL
    """(2,) what carries it sideways, in the world frame [m/s]."""
    seen: bool = False
    """Whether the pose comes from relative sensing, rather than from the plan alone."""


class Horizon(NamedTuple):
    """The reference from where the plan begins: what a robot would do if it were in its slot."""

    slots: FloatArray
    """(N + 1, 3) own slot, one row a prediction interval [m, m, rad]."""
    inputs: FloatArray
    """(N, 2) body velocities that keep to it [m/s, rad/s]."""
    upstream_slots: FloatArray
    """(N + 1, 3) of the upstream neighbour."""
    upstream_inputs: FloatArray
    """(N, 2) of the upstream neighbour."""


class Observation(NamedTuple):
    """The robot where its plan begins, and what it knows of its neighbours. New fields have defaults."""

    k: int
    """Tick at which the plan begins: now, and the time that commands need to have an effect."""
    pose: FloatArray
    """(3,) [m, m, rad]."""
    upstream: NeighborEstimate
    downstream: NeighborEstimate | None = None
    """None unless the controller hears both neighbours."""
    speed: FloatArray = STILL
    """(2,) speeds of the wheels there [m/s, rad/s]."""
    disturbance: FloatArray = NONE
    """(3,) estimated body velocity that no command makes: forward, lateral [m/s], turn [rad/s]."""
    covariance: FloatArray = CERTAIN
    """(3, 3) of the estimated pose."""
    alarm_age: float = math.inf
    """Since the last detection of a disturbance of the own robot [s]."""
    rejected: int = 0
    """Localisations rejected in a row."""
    motor_gap: float = 0.0
    """Speed that was commanded less that of the wheels, in the last tick [m/s]."""
    motor_lag: float = 0.0
    """Time constant of the wheels [s]."""
    kept_off: FloatArray | None = None
    """(2,) mean speeds since the last plan that the last filter allowed, if it changed a command [m/s, rad/s]."""
    lost: bool = False
    """Whether the robot was told the path too long ago; its own reference then is nobody's but that of others lost."""
    drift_noise: float = 0.0
    """Of the lateral part of the disturbance so much may be noise [m/s], see estimator.doubt."""
    bodies: FloatArray = NOBODY
    """(B, 6) the bodies near by, if robots avoid each other: position [m] and velocity [m/s] in the world, sum of both
    radii, and the distance of the centres to keep [m]."""
    limits: FloatArray = STILL
    """(2,) largest |v| and |omega| [m/s, rad/s]; given to controllers of users' own."""
    reference: Horizon | None = None
    """Given to controllers of users' own; the others ask their Task."""

    def believes(self, tick: float, interval: float) -> Motion:
        """What this says of the neighbour upstream, for displays; a tick and an input last so long [s]."""
        return Motion(self.k * tick, self.upstream.pose.copy(), interval, self.upstream.inputs.copy())


class Solution(NamedTuple):
    """A controller's result."""

    inputs: FloatArray
    """(N, 2) body velocities to command over the horizon [m/s, rad/s]."""
    converged: bool = True
    """False if the solver failed and the inputs are a fallback."""
    lag: float = 0.0
    lag_rate: float = 0.0
    waits: bool = False
    news: FloatArray = NO_NEWS
    """As in network.messages.Plan."""
    motion: FloatArray | None = None
    """(N, 2) mean body velocities that the inputs lead to, for the plan; the inputs themselves if None."""


PROTOCOL = 1
"""Number of this interface; a class of a user's own may name it as `protocol` and is refused once it is another."""


class Controller(Protocol):
    """Plans for one robot. It may remember its last plan; it reads no clock."""

    def plan(self, observation: Observation) -> Solution:
        """Inputs from now on."""
        ...


class Team(Protocol):
    """Plans for all robots at once, in one process; reads no clock."""

    @property
    def lag(self) -> float:
        """How far the reference time of all is behind the clock [s]."""
        ...

    def see(self, k: int, poses: FloatArray, speeds: FloatArray, commands: FloatArray) -> None:
        """Take what is true at tick k, before any member plans.

        Args:
            k: now; call it for every tick.
            poses: (n, 3) [m, m, rad].
            speeds: (n, 2) of the wheels over the tick before [m/s, rad/s].
            commands: (n, 2) that reached the robots at the tick before [m/s, rad/s].
        """
        ...

    def reshape(self, scenario: Scenario, k: int) -> None:
        """From tick k on the formation has the offsets of this scenario; before it they are the same."""
        ...

    def member(self, robot: int) -> Controller:
        """The controller of one robot: its part of the plan."""
        ...


Options = TypeVar("Options", bound=ControllerOptions)


def options_of(scenario: Scenario, kind: type[Options]) -> Options:
    """The scenario's options of this controller; the default ones if it names another controller."""
    own = scenario.controller
    return own if isinstance(own, kind) else kind.model_validate({})
