"""Scenario files: path, formation, robots, controller, faults and noise (docs/design.md, section 7)."""

from collections.abc import Collection, Iterable
from functools import cached_property
from typing import Annotated

import numpy as np
from pydantic import Field, model_validator

from formation.arrays import FloatArray, frozen
from formation.bodies.nominal import Nominal, nominal
from formation.bodies.spec import Bodies
from formation.clear.stopping import top_speed
from formation.disturbances import Disturbance, robots_missing
from formation.driving.law import Law, at_rest, law_of
from formation.driving.reference import DrivenReference
from formation.driving.track import Dated, Track
from formation.errors import FaultError
from formation.faults import Fault, ScheduledFault
from formation.feasibility import Feasibility, examine, unexamined
from formation.formation_spec import Formation
from formation.link_ids import links_named
from formation.offsets import Offsets
from formation.orientation import orientation_of
from formation.paths.driven import Driven
from formation.paths.kinds import AnyPath
from formation.paths.turns import Turn, spike, tight_turns
from formation.pattern import Pattern, leader, pattern, ring_from
from formation.reference import Block, Reference
from formation.scenario import places
from formation.scenario.any_controller import AnyController
from formation.scenario.controllers import NashOptions
from formation.scenario.estimator import Estimator
from formation.scenario.lockstep import Lockstep
from formation.scenario.membership import Membership
from formation.scenario.metrics import Metrics
from formation.scenario.registry import spec_of, told
from formation.scenario.robots import Noise, Robots
from formation.schedule import Schedule
from formation.schema import Duration, Model, Positive
from formation.slot_motion import Course, Motion
from formation.validation import LABEL
from formation.way import HeardReference

MAX_TICKS = 1_000_000
"""Ticks of one episode: nearly three hours at 100 Hz; the trace of 64 robots is then 2 GB."""
MAX_STRIDE = 1000
"""Control intervals in one prediction interval."""


class Scenario(Model):
    """The complete description of an episode: it determines every trajectory, seed included."""

    name: Annotated[str, Field(pattern=LABEL)]
    """What tables and the page call it: letters and digits, and _ . - between them."""
    source: str = ""
    """Where it comes from."""
    duration: Annotated[Duration, Field(gt=0.0)] = 60.0
    """Of an episode, in simulated time [s]."""
    seed: Annotated[int, Field(ge=0, lt=2**63)] = 0
    """Of everything that is drawn: noise, faults, start noise, differences between robots."""
    control_interval: Positive = 0.01
    """delta_t, the length of a tick [s]."""
    path: AnyPath
    """Where the centre of the formation shall be at which time."""
    formation: Formation
    robots: Robots = Robots()
    noise: Noise = Noise()
    controller: AnyController = NashOptions()
    """What plans for each robot."""
    bodies: Bodies = Bodies()
    """The physical model: motors, slip, sensors."""
    estimator: Estimator = Estimator()
    lockstep: Lockstep = Lockstep()
    membership: Membership = Membership()
    metrics: Metrics = Metrics()
    link: Fault = Fault()
    """Fault of every link that carries plans, under the scheduled faults and those that users set."""
    faults: tuple[ScheduledFault, ...] = ()
    disturbances: tuple[Disturbance, ...] = ()
    """Disturbances of the bodies."""

    @model_validator(mode="after")
    def _consistent(self) -> "Scenario":
        if self.path.known_to == "leader" and spec_of(self.controller).needs_path:
            other = "a path of another kind" if self.driven else "all"
            raise ValueError(
                f"path.known_to: {self.controller.name} needs the path in every robot: expected {other}, or a "
                f"controller that follows what it is told ({', '.join(told())})"
            )
        if self.path.wait_for_lost and not self._waits_for_lost:
            raise ValueError(
                'path.wait_for_lost: expected known_to = "leader", a path that is not driven, and nash with game = '
                f'"response", which can wait; got {self.path.kind}, {self.path.known_to}, {self.controller.name}'
            )
        for line in places.mistakes(self.formation, self.robots, self.bodies):
            raise ValueError(line)
        ratio = self.controller.prediction_interval / self.control_interval
        if not 1.0 <= ratio <= MAX_STRIDE or abs(ratio - round(ratio)) > 1e-6:
            raise ValueError(
                "controller.prediction_interval: expected a whole number of control intervals "
                f"({self.control_interval:g} s); got {self.controller.prediction_interval:g}"
            )
        most = MAX_TICKS * self.control_interval
        if self.duration > most:
            raise ValueError(f"duration: expected at most {most:g} s at this control_interval; got {self.duration:g}")
        for index, fault in enumerate(self.faults):
            try:
                links_named(fault.link, self.size, both=self.controller.uses_downstream, driven=self.driven)
            except FaultError as error:
                raise ValueError(f"faults[{index}].link: {error}") from None
        if twice := self.noise.also_in(self.bodies):
            raise ValueError(f"noise: expected {', '.join(twice)} either here or in bodies; got both")
        nominal(self.body, self.control_interval)
        self.estimator.ticks_late(self.control_interval)
        for line in (*robots_missing(self.disturbances, self.size), *self.membership.mistakes(self.formation)):
            raise ValueError(line)
        if wrong := self.offsets.crowded():
            raise ValueError(f"formation.changes: {wrong}")
        if self.formation.orientation == "path" and (wrong := spike(self.path, self.offsets.reach)):
            raise ValueError(f"path: {wrong}")
        return self

    @property
    def size(self) -> int:
        """Number of robots."""
        return len(self.formation.array)

    @cached_property
    def body(self) -> Bodies:
        """The bodies, with [noise], which is another way to write four of their keys."""
        given: dict[str, float] = {key: value for key, value in self.noise.model_dump().items() if value}
        if not given:
            return self.bodies
        sensor = self.bodies.localisation
        seen: dict[str, float] = {key: given.pop(key) for key in ("position", "heading") if key in given}
        return self.bodies.model_copy(update={**given, "localisation": sensor.model_copy(update=seen)})

    @cached_property
    def nominal(self) -> Nominal:
        """What everybody may know of the bodies."""
        return nominal(self.body, self.control_interval)

    @property
    def spacing(self) -> float:
        """The smallest distance between two neighbours in the ring at the start [m]: the unit of length."""
        return float(self.pattern.distance.min())

    @cached_property
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
    def offsets(self) -> Offsets:
        """Where the robots stand in the formation, by the path's time."""
        return Offsets(self.formation, self.path, self.bodies.width(self.size))

    @property
    def _waits_for_lost(self) -> bool:
        """Whether there is a time that all can wait by: a user drives on by the clock."""
        waits = isinstance(self.controller, NashOptions) and self.controller.game == "response"
        return waits and self.path.known_to == "leader" and not self.driven

    @property
    def driven(self) -> bool:
        """Whether the path is ordered while the run goes on."""
        return isinstance(self.path, Driven)

    @property
    def law(self) -> Law:
        """How the centre of a driven formation answers to orders."""
        assert isinstance(self.path, Driven)
        return law_of(self.path, self.formation, *self._limits, self.offsets.reach, self.control_interval)

    def driving(self, robots: Iterable[int] | None = None) -> DrivenReference:
        """The reference of these robots, or of all, along a driven path before any order."""
        assert isinstance(self.path, Driven)
        offsets = self.offsets if robots is None else self.offsets.rows(list(robots))
        track = Track(self.law, 0, at_rest(self.path, self.formation))
        return DrivenReference(track, offsets, stride=self.stride, horizon=self.controller.horizon)

    def reference(self, robots: Iterable[int] | None = None, *, rounded: bool = False) -> Reference | DrivenReference:
        """The reference of these robots (numbers, from 1), or of all; of a driven path, by the scenario's own orders.

        Args:
            robots: whose.
            rounded: whether the formation turns smoothly where the path's heading jumps.
        """
        if isinstance(self.path, Driven):
            reference = self.driving(robots)
            for k, order in self.orders:
                reference.order(k, order)
            return reference
        return Reference(
            self._motion(None if robots is None else list(robots), rounded=rounded),
            self._schedule,
            control_interval=self.control_interval,
            stride=self.stride,
            horizon=self.controller.horizon,
        )

    @property
    def orders(self) -> list[Dated]:
        """The orders that the scenario itself gives, the later ones last."""
        law, tick = self.law, self.control_interval
        return [Dated(round(t / tick), law.within(v, omega)) for t, v, omega in getattr(self.path, "commands", ())]

    @cached_property
    def start(self) -> Block:
        """The reference around t = 0, before any order."""
        return (self.driving() if self.driven else self.reference()).block(0)

    def heard_reference(
        self, robots: Iterable[int], away: Collection[int] = (), *, rounded: bool = False
    ) -> HeardReference:
        """The reference of robots that are told the path; arguments as of `reference`, and who has left the ring."""
        start = self.driving([1]).preview(-1) if self.driven else self.reference([1], rounded=rounded).preview(0)
        return HeardReference(
            self.offsets.rows(list(robots)),
            start,
            control_interval=self.control_interval,
            stride=self.stride,
            horizon=self.controller.horizon,
            v_max=self.robots.limits.v,
            ring=ring_from(leader(away, follows=self.path.leader == "next"), self.size, away),
            revised=self.driven,
        )

    def _motion(self, robots: list[int] | None = None, *, rounded: bool) -> Motion:
        offsets, interval, made = self.offsets, self.controller.prediction_interval, self._found[1]
        if (rounded := rounded and bool(self.path.corners)) not in made:
            orientation = orientation_of(
                self.formation,
                self.path,
                interval=interval,
                reaches=offsets.reaches,
                rounded=rounded,
                tight=lambda reach: bool(self._turns(reach)),
            )
            made[rounded] = Course(self.path, orientation, interval)
        return Motion(made[rounded], offsets if robots is None else offsets.rows(robots), robots)

    @cached_property
    def _schedule(self) -> Schedule:
        """Of all robots, in every reference."""
        return Schedule(self._motion(rounded=True), np.array(self._limits), self.control_interval)

    @cached_property
    def _found(self) -> tuple[dict[float, list[Turn]], dict[bool, Course]]:
        """Turns that are too tight, by reach [m]; courses, by `rounded`, for all robots: both are long to make."""
        return {}, {}

    def _turns(self, reach: float) -> list[Turn]:
        interval, step, found = self.controller.prediction_interval, self.control_interval, self._found[0]
        if self.formation.orientation != "path":
            return []
        if reach not in found:
            found[reach] = tight_turns(self.path, reach=reach, interval=interval, step=step, until=self._examined)
        return found[reach]

    @cached_property
    def _limits(self) -> tuple[float, float]:
        """Of what slots may ask for, v and omega; robots that keep off each other can stop in time [m/s, rad/s]."""
        v, omega = self.robots.limits.v, self.robots.limits.omega
        if self.robots.avoid:
            v = top_speed(v, self.spacing, self.bodies.radii(self.size), self.nominal, self.control_interval)
        return v, omega

    @property
    def _examined(self) -> float:
        """How far a path is looked at before it is driven, by its own time [s]: a lap, or to the end."""
        period = self.path.period
        lap = self.duration if period is None else period + self.offsets.settled
        return min(lap, MAX_TICKS * self.control_interval)

    def feasibility(self) -> Feasibility:
        """Whether the robots can follow the reference, slot by slot, and where not; orders are within what they can."""
        if self.driven:
            return unexamined(self.size, self._limits, self.offsets.reach)
        motion, turns = self._motion(rounded=True), self._turns(self.offsets.reach)
        found = examine(motion, self._schedule, self._limits, turns, until=self._examined, duration=self.duration)
        return found._replace(stops=self._limits[0] < self.robots.limits.v)

    def start_poses(self) -> FloatArray:
        """Poses (n, 3) at t = 0, with start noise drawn from the seed [m, m, rad]."""
        poses = self.start.slots[0] if self.robots.poses is None else np.array(self.robots.poses)
        noise = self.robots.start_noise
        draws = np.random.Generator(np.random.Philox(key=[self.seed, 1])).standard_normal(poses.shape)
        return frozen(poses + np.array([noise.position, noise.position, noise.heading]) * draws)
