"""The agent of one robot, without any I/O: measurements and plans in, a command and a plan out; in both engines."""

from collections.abc import Collection, Mapping
from time import perf_counter

import numpy as np

from agents.avoidance import Avoidance
from agents.controllers.guarded import ControllerFailedError
from agents.controllers.interface import NOBODY, Controller, NeighborEstimate, Observation, Solution
from agents.controllers.pair_game import Game
from agents.controllers.registry import controller_for
from agents.controllers.task import Task
from agents.driver_receiver import DriverReceiver
from agents.estimator import NONE, STILL, Estimate, Estimator, LatestPose, Measurement, measured
from agents.motor_model import MotorModel, within
from agents.plan_receiver import PlanReceiver
from agents.sending import Answer, Sending
from agents.window_estimator import WindowEstimator
from formation.arrays import FloatArray
from formation.faults import PERFECT, Fault
from formation.link_ids import LinkId
from formation.pattern import neighbours
from formation.scenario.registry import spec_of
from formation.scenario.scenario import Scenario
from network.link import Link
from network.messages import Command, Plan, Status, Tick
from network.values import NO_WAY, LinkCounts, maker, tuple_maker

_make_plan, _make_command = maker(Plan), maker(Command)
_observe, _make_answer = tuple_maker(Observation), tuple_maker(Answer)


class Agent:
    """The agent of one robot for one episode."""

    def __init__(
        self,
        scenario: Scenario,
        robot: int,
        *,
        episode: int = 0,
        controller: Controller | None = None,
        away: Collection[int] = (),
    ) -> None:
        """An agent at the start of an episode.

        Args:
            scenario: of the run.
            robot: its number, from 1.
            episode: put into every message; plans with another one are not for this episode.
            controller: instead of the scenario's own for this robot (agents/controllers/centralised.py).
            away: robots over which the ring is closed; if it is one of them, it stands.
        """
        own = scenario.controller
        self.robot, self.episode, self.size, self._away = robot, episode, scenario.size, robot in away
        (self.upstream, _, after), self.planning = neighbours(robot, scenario.size, away), own.plan_every
        self._task = Task(scenario, robot, away)
        self._game = Game(scenario, robot, self._task)
        self._controller = controller or controller_for(scenario, robot, self._task)
        self._ages = spec_of(own).ages_plans if own.age_plans is None else own.age_plans
        self._receivers = [PlanReceiver(scenario, self.upstream, robot)]
        if own.uses_downstream and after != self.upstream:
            self._receivers.append(PlanReceiver(scenario, after, robot))
        self._driver = DriverReceiver.of(scenario, robot, away)
        self._motors = MotorModel(scenario, self._task.limits)
        raw = not spec_of(own).estimates or not scenario.estimator.enabled
        hears = {"sees": own.uses_sight, "listens": own.uses_plans}
        window = None if raw else WindowEstimator(scenario, self._task, self._motors, **hears)
        self._estimator: Estimator = window or LatestPose(scenario)
        self._compensates = scenario.estimator.disturbances and not raw
        self._doubt = scenario.estimator.doubt if self._compensates else 0.0
        self._measurements: Link[Measurement] = Link(scenario.seed, LinkId.poses_to(robot))
        self._avoidance = Avoidance(scenario, robot, self._motors)
        self._limits: list[float] = self._task.limits.tolist()
        self._speed: FloatArray = STILL
        self._last: tuple[int, Solution, FloatArray, list[float]] | None = None
        self._failure = ""  # of a user's own controller: until a reset the robot stands, and publishes no plan
        self.observation: Observation | None = None  # what the controller was asked with last
        self._sending = Sending(own.send_when, scenario.spacing)
        self._acting, self._fresh, self._solves = 0.0, True, list[float]()

    def set_faults(self, faults: Mapping[LinkId, Fault]) -> None:
        """Set the faults of the links to this robot from now on; a link that is not named is perfect."""
        for receiver in self._receivers:
            receiver.set_faults(faults)
        self._measurements.fault = faults.get(self._measurements.id, PERFECT)
        self._avoidance.set_faults(faults)
        if self._driver:
            self._driver.set_faults(faults)

    def reshape(self, scenario: Scenario, k: int) -> None:
        """From tick k on the formation has the offsets of this scenario; before it they are the same."""
        self._task.reshape(scenario, k)
        self._estimator.reshape()
        if self._driver:
            self._driver.reshape(k, scenario)

    @property
    def hears(self) -> list[int]:
        """Whose plans it takes."""
        return [receiver.sender for receiver in self._receivers]

    @property
    def heard(self) -> int:
        """seq of the upstream neighbour's newest plan that came in physically; -1 before the first."""
        return self._receivers[0].newest

    def lacks(self, tick: Tick) -> bool:
        """Whether a plan of the tick before, which has been sent to it, has not come in yet."""
        return any(receiver.sender in tick.planned and receiver.newest < tick.seq - 1 for receiver in self._receivers)

    def receive(self, plan: Plan) -> None:
        """A plan of a neighbour came in physically; now it enters the faulty link.

        A plan of another episode, of somebody else, or one that was there before is ignored.
        """
        for receiver in self._receivers:
            if plan.episode == self.episode and plan.sender == receiver.sender:
                receiver.push(plan)

    def step(self, tick: Tick) -> Answer:
        """Answer a tick; its number grows from call to call."""
        k, stamp, belief = tick.seq, tick.stamp, self._receivers[0].belief
        if self._away:
            return self._stand(k, stamp, 0.0)
        if k > 0 and self._fresh:
            self._task.forget()
        self._fresh = False
        for receiver in self._receivers:
            if receiver.pop(stamp):
                plan = receiver.belief.plan
                assert plan is not None
                self._task.hear(plan.way, k + self._motors.delay, plan.sender, plan.lost)
                if receiver is self._receivers[0]:
                    self._estimator.hear(plan)
        if self._driver:
            self._driver.receive(tick)
            preview = self._driver.preview(k) if k % self.planning == 0 or self._last is None else None
            if preview is not None:
                self._task.hear(preview, k + self._motors.delay)
        self._measure(tick)
        self._avoidance.look(tick)
        age = belief.seconds_old(stamp)
        if self._failure:
            return self._stand(k, stamp, age)
        plan, solve = None, 0.0
        if k % self.planning == 0 or self._last is None:
            began = perf_counter()
            own = self._estimator.estimate(k, belief.plan)
            if own is None or not self._task.knows:  # who does not know where it is, or the way, does not move
                return self._stand(k, stamp, age)
            try:
                plan = self._sending.offer(self._plan(k, stamp, own))
            except ControllerFailedError as error:
                self._failure = str(error)
                return self._stand(k, stamp, age)
            solve = perf_counter() - began
            self._solves.append(solve)
        v, omega = self._input(k)
        v, omega = self._avoidance.filter(k, self._speed, v, omega)
        self._motors.command(k, v, omega)
        good, off = self._converged, self._avoidance.who
        command = _make_command(self.robot, k, stamp, self.episode, v, omega, age, plan is not None, solve, good, off)
        return _make_answer(command, plan)

    def _stand(self, k: int, stamp: float, age: float) -> Answer:
        """Command zero, and publish nothing."""
        command = _make_command(self.robot, k, stamp, self.episode, 0.0, 0.0, age, False, 0.0, failure=self._failure)
        return Answer(command, None)

    def _measure(self, tick: Tick) -> None:
        """Own row of what the sensors deliver: odometry at once, the rest over the link from the world."""
        k, row, at_once = tick.seq, self.robot - 1, self._measurements.transparent
        measurement = measured(tick, row) if tick.measured is not None else None
        if k > 0:
            self._acting = self._motors.acting(k - 1)
            self._speed = tick.odometry[row]
            self._estimator.roll(k, self._speed, measurement if at_once else None)
        elif self._last is None:
            self._speed = tick.odometry[row]
            self._estimator.begin(self._speed)
            if at_once and measurement is not None:
                self._estimator.sense(measurement)
        if at_once:
            return
        if measurement is not None:
            self._measurements.push(k, tick.stamp, measurement)
        for arrival in self._measurements.pop(tick.stamp):
            if arrival.damage is None:
                self._estimator.sense(arrival.message)

    def _plan(self, k: int, stamp: float, own: Estimate) -> Plan:
        """Decide what to do, and say it."""
        task, motors, receivers, estimator = self._task, self._motors, self._receivers, self._estimator
        at, delay = k + motors.delay, motors.delay * task.tick
        begins, belief, avoidance = stamp + delay, receivers[0].belief, self._avoidance
        aged = belief.ahead(begins, at, task, 1) if self._ages else belief.as_if_fresh(*task.slot(at, 1))
        other = receivers[1].belief.ahead(begins, at, task, 3) if len(receivers) > 1 else None
        less, drift = (own.input_disturbance, own.drift) if self._compensates else (STILL, STILL)
        observation = self.observation = _observe(
            at,
            own.pose,
            self._sighted(aged) if estimator.sees else aged,
            other,
            own.speed,
            own.disturbance if self._compensates else NONE,
            own.covariance,
            own.alarm_age,
            own.rejected,
            self._acting - float(self._speed[0]) if k > 0 else 0.0,
            motors.lag,
            avoidance.take(),
            task.lost(at),
            own.drift_sigma * self._doubt,
            avoidance.near(k, self._speed, own.pose, less, task.slot(at, 0)[0]) if avoidance.works else NOBODY,
        )
        solution = self._controller.plan(observation)
        self._last = (k, solution, own.pose, less.tolist())
        lost = task.first_lost if observation.lost else 0
        # By place, in the order of network.messages.Plan: by keywords it takes a microsecond more.
        return _make_plan(
            self.robot,
            k,
            stamp,
            self.episode,
            own.pose,
            task.interval,
            solution.inputs if solution.motion is None else solution.motion,
            solution.lag,
            solution.lag_rate,
            delay,
            solution.waits,
            drift,
            own.twist,
            own.input_disturbance,
            own.odometry,
            own.measurements,
            solution.news,
            task.preview(k),
            lost,
            self._sending.next,
        )

    def _sighted(self, aged: NeighborEstimate) -> NeighborEstimate:
        """The upstream neighbour as it is seen."""
        pose, drift = self._estimator.neighbour()
        return NeighborEstimate(pose, aged.inputs, aged.plan, aged.age, drift, seen=True)

    def _input(self, k: int) -> tuple[float, float]:
        """The command for tick k: the last plan's input, less what disturbs the robot, within the limits."""
        assert self._last is not None
        made, solution, _, (less_v, less_omega) = self._last
        inputs, (v_max, omega_max) = solution.inputs, self._limits
        j = min((k - made) // self._task.stride, len(inputs) - 1) if k > made else 0
        return within(inputs.item(j, 0) - less_v, v_max), within(inputs.item(j, 1) - less_omega, omega_max)

    def status(self, k: int, stamp: float, *, missed: int = 0, rejected: int = 0, pid: int = 0) -> Status:
        """Its Status at tick k, which it has just answered; the arguments are what only its process knows."""
        solves, self._solves, sent, asked = self._solves, [], self._sending.last, self.observation
        return Status(
            sender=self.robot,
            seq=k,
            stamp=stamp,
            episode=self.episode,
            link=self._receivers[0].id,
            age=self._receivers[0].belief.seconds_old(stamp),
            plan=self._sending.motion,
            counts=self.counts(),
            solve=sum(solves) / max(1, len(solves)),
            missed=missed,
            gap=self._gap(k, stamp),
            rejected=rejected,
            pid=pid,
            converged=self._converged,
            way_age=self._driver.age(k) if self._driver else self._task.way_age(k),
            lost=sent is not None and sent.lost > 0,
            lag=sent.lag if sent else 0.0,
            way=sent.way if sent else NO_WAY,
            plan_bytes=self._sending.size,
            keeps_off=self._avoidance.who,
            believes=asked.believes(self._task.tick, self._task.interval) if asked else None,
        )

    @property
    def _converged(self) -> bool:
        """Whether the newest plan is the solver's, not a fallback."""
        return self._last is None or self._last[1].converged

    def counts(self) -> LinkCounts:
        """What became of the plans sent to this robot by its upstream neighbour."""
        return self._receivers[0].counts()

    def _gap(self, k: int, stamp: float) -> float:
        if self._last is None or self._last[0] != k:
            return 0.0
        _, solution, own, _ = self._last
        at, begins = k + self._motors.delay, stamp + self._motors.delay * self._task.tick
        other = self._receivers[0].belief.aged(begins, *self._task.slot(at, 1))
        return self._game.gap(at, np.concatenate([own, other.pose]), np.hstack([solution.inputs, other.inputs]))
