"""Scenario files: path, formation, robots, controller, faults and noise (docs/design.md, section 7)."""

from collections.abc import Iterable
from functools import cached_property
from typing import Annotated, Literal

import numpy as np
from pydantic import Field, FiniteFloat, model_validator

from formation.arrays import FloatArray, frozen
from formation.disturbances import Disturbance, robots_missing
from formation.errors import FaultError
from formation.faults import Fault, ScheduledFault
from formation.formation_spec import Formation
from formation.links import links_named
from formation.offsets import Offsets
from formation.orientation import orientation_of
from formation.paths.kinds import AnyPath
from formation.pattern import Pattern, pattern
from formation.reference import Reference
from formation.scenario.registry import WEIGHTS, ControllerName
from formation.schema import Duration, Model, NonNegative, Positive

MAX_TICKS = 1_000_000
"""Ticks of one episode: nearly three hours at 100 Hz; the trace of 64 robots is then 2 GB."""
MAX_STRIDE = 1000
"""Control intervals in one prediction interval."""
Triple = tuple[FiniteFloat, FiniteFloat, FiniteFloat]


class Limits(Model):
    """Limits of a robot's inputs: |v| <= v, |omega| <= omega."""

    v: Positive = 0.5
    """[m/s]."""
    omega: Positive = 2.0
    """[rad/s]."""


class StartNoise(Model):
    """Standard deviations of the start poses."""

    position: NonNegative = 0.0
    """[m], in x and in y."""
    heading: NonNegative = 0.0
    """[rad]."""


class Robots(Model):
    """The bodies: start poses and limits."""

    poses: list[Triple] | None = None
    """Start poses [m, m, rad]; in formation if absent."""
    limits: Limits = Limits()
    start_noise: StartNoise = StartNoise()


class Noise(Model):
    """Noise, which the prediction model leaves out (docs/theory.md, section 9); n is standard normal."""

    slip: NonNegative = 0.0
    """Each tick v and omega are multiplied by 1 + slip n, each with its own n."""
    gyro: NonNegative = 0.0
    """Each tick gyro n is added to omega [rad/s]."""
    position: NonNegative = 0.0
    """Error of the measured x and y [m]."""
    heading: NonNegative = 0.0
    """Error of the measured heading [rad]."""


class Controller(Model):
    """The agents' controller. Weights that are absent are the controller's defaults."""

    name: ControllerName = "nash"
    horizon: Annotated[int, Field(ge=2, le=100)] = 20
    """N [prediction intervals]."""
    prediction_interval: Positive = 0.1
    """Delta_T [s]; a whole number of control intervals."""
    plan_every: Annotated[int, Field(ge=1, le=100)] = 1
    """Ticks from one plan to the next; in between the plan's own inputs are applied."""
    age_plans: bool | None = None
    """Roll a received plan forward to now (nash, consensus), or take it as if fresh (paper, leader_follower)."""
    q: list[NonNegative] | None = None
    """Diagonal of Q. nash, centralised: centre, centre, mean heading, radial, tangential, half-difference of headings;
    paper: x_e, y_e, theta_e, l_e, psi_e; virtual_structure: x, y, heading."""
    r: Annotated[list[Positive], Field(min_length=2, max_length=2)] | None = None
    """Diagonal of R: v, omega."""
    formation: Positive = 0.3
    """Weight of the pattern relative to the path (nash); all other weights are derived from the spacing. A larger value
    holds the pattern tighter and makes it depend more on fresh messages."""
    waits: bool = True
    """Whether a robot waits for those that cannot keep up (nash)."""
    errata: tuple[Literal[1, 2, 3, 4, 5, 13, 14], ...] = ()
    """Errata of the paper's algorithm that are corrected in `paper`, 13 in `leader_follower`; none by default."""
    misprints: tuple[Literal[6, 7, 11], ...] = ()
    """Errata that are brought back; without them the tests' data follow from the offsets. `paper`: 6, the virtual
    centre of the triangle; 7, psi_r of the second of two robots. `leader_follower`: 11."""
    gains: tuple[Positive, Positive] = (0.1, 0.1)
    """k_x and k_theta of `leader_follower`."""

    @model_validator(mode="after")
    def _weights(self) -> "Controller":
        expected = WEIGHTS.get(self.name)
        if self.q is not None and expected is not None and len(self.q) != expected:
            raise ValueError(f"expected {expected} values in q for {self.name}; got {len(self.q)}")
        return self


class Scenario(Model):
    """The complete description of an episode: it determines every trajectory, seed included."""

    name: Annotated[str, Field(pattern=r"^[A-Za-z0-9][A-Za-z0-9_.-]{0,63}$")]
    source: str = ""
    """Where it comes from."""
    duration: Annotated[Duration, Field(gt=0.0)] = 60.0
    """[s]."""
    seed: Annotated[int, Field(ge=0, lt=2**63)] = 0
    control_interval: Positive = 0.01
    """delta_t, the length of a tick [s]."""
    path: AnyPath
    formation: Formation
    robots: Robots = Robots()
    noise: Noise = Noise()
    controller: Controller = Controller()
    link: Fault = Fault()
    """Fault of every link between robots, under the scheduled faults and those that users set."""
    faults: tuple[ScheduledFault, ...] = ()
    disturbances: tuple[Disturbance, ...] = ()
    """Disturbances of the bodies."""

    @model_validator(mode="after")
    def _consistent(self) -> "Scenario":
        poses = self.robots.poses
        if poses is not None and len(poses) != self.size:
            raise ValueError(f"robots.poses: expected {self.size} poses for this formation; got {len(poses)}")
        ratio = self.controller.prediction_interval / self.control_interval
        if not 1.0 <= ratio <= MAX_STRIDE or abs(ratio - round(ratio)) > 1e-6:
            raise ValueError(
                "controller.prediction_interval: expected a whole number of control intervals "
                f"({self.control_interval:g} s); got {self.controller.prediction_interval:g}"
            )
        if self.duration / self.control_interval > MAX_TICKS:
            raise ValueError(
                f"duration: expected at most {MAX_TICKS * self.control_interval:g} s at this control_interval; "
                f"got {self.duration:g}"
            )
        for index, fault in enumerate(self.faults):
            try:
                links_named(fault.link, self.size)
            except FaultError as error:
                raise ValueError(f"faults[{index}].link: {error}") from None
        for line in robots_missing(self.disturbances, self.size):
            raise ValueError(line)
        return self

    @property
    def size(self) -> int:
        """Number of robots."""
        return len(self.formation.array)

    @property
    def spacing(self) -> float:
        """The smallest distance between two neighbours in the ring at the start [m]: the unit of length."""
        return float(self.pattern.distance.min())

    @property
    def ticks(self) -> int:
        """Number of control intervals in the duration."""
        return max(1, round(self.duration / self.control_interval))

    @property
    def stride(self) -> int:
        """Ticks in one prediction interval."""
        return round(self.controller.prediction_interval / self.control_interval)

    @cached_property
    def pattern(self) -> Pattern:
        """The pattern of every pair at the start."""
        return pattern(self.formation.array)

    @cached_property
    def _offsets(self) -> Offsets:
        return Offsets(self.formation, self.path)

    def reference(self, robots: Iterable[int] | None = None, *, rounded: bool = False) -> Reference:
        """The reference of these robots (numbers, from 1), or of all.

        Args:
            robots: whose.
            rounded: whether the formation turns smoothly where the path's heading jumps.
        """
        offsets = self._offsets
        interval = self.controller.prediction_interval
        return Reference(
            self.path,
            offsets if robots is None else offsets.rows(list(robots)),
            orientation_of(self.formation, self.path, interval=interval, reach=offsets.reach, rounded=rounded),
            control_interval=self.control_interval,
            stride=self.stride,
            horizon=self.controller.horizon,
        )

    def start_poses(self) -> FloatArray:
        """Poses (n, 3) at t = 0, with start noise drawn from the seed [m, m, rad]."""
        poses = self.reference().block(0).slots[0] if self.robots.poses is None else np.array(self.robots.poses)
        noise = self.robots.start_noise
        spread = np.array([noise.position, noise.position, noise.heading])
        draws = np.random.Generator(np.random.Philox(key=[self.seed, 1])).standard_normal(poses.shape)
        return frozen(poses + spread * draws)
