"""The window filter of one robot: raw measurements in, an estimate out (docs/theory.md, section 12)."""

import math

import numpy as np

from agents.controllers.task import Task
from agents.estimator import STILL, Estimate, Measurement
from agents.kernels.window import estimation
from agents.kernels.window.estimation import (
    DISTURBANCE,
    DRIFT,
    DRIFT_SIGMA,
    INPUT_DISTURBANCE,
    NEIGHBOUR,
    NEIGHBOUR_DRIFT,
    POSE,
    RESULTS,
    SPEED,
    TWIST,
)
from agents.kernels.window.filter import COLUMNS, KEPT
from agents.kernels.window.state import HEARD, LENGTH, SIGHT, FlatWindow, Window, start, tuning, view
from agents.motor_model import MotorModel
from formation.arrays import FloatArray
from formation.scenario.scenario import Scenario
from network.messages import Plan
from network.values import tuple_maker

_make_estimate = tuple_maker(Estimate)

FAR, TURNED = 0.5, 1.0
"""Standard deviations of where a neighbour is believed to start if robots do not start in formation [m, rad]."""
IN_PLACE, IN_LINE = 0.001, 0.01
"""The same if they do."""
NOWHERE: FloatArray = np.zeros(3)
SILENCE = (-math.inf, 1.0, np.zeros((1, 2)), STILL, STILL)
"""No plan, as compiled code takes it."""
UNMEASURED = (0, False, NOWHERE, False, STILL)
"""No measurement, likewise."""
NOT_PASSED = np.empty((0, 4)), np.empty((0, COLUMNS))
"""Odometry and measurements in plans of who passes nothing on."""


class WindowEstimator:
    """One joint filter over the own robot and those upstream, fed with raw measurements at their own stamps."""

    def __init__(self, scenario: Scenario, task: Task, motors: MotorModel, *, sees: bool, listens: bool) -> None:
        """A robot that does not know where it is, unless robots start in formation.

        Args:
            scenario: of the run.
            task: the robot's task; its columns are the blocks of the window.
            motors: its commands and their delay.
            sees: whether the controller uses sight of the upstream neighbour, where the bodies have it.
            listens: whether the neighbour's measurements come with its plans; else it is only seen.
        """
        wish, body = scenario.estimator, scenario.nominal
        self.sees = sees and wish.relative and body.relative is not None
        """Whether the upstream neighbour is in the window."""
        self.blocks = min(wish.window, task.members) if self.sees else 1
        """W, robots in the window."""
        self._task, self._motors, self._dt = task, motors, scenario.control_interval
        self._ring = task.members
        self._mode = HEARD if listens else SIGHT
        constants = tuning(body, self._dt, sees=self.sees, detects=wish.disturbances)
        self._late, self._tuning = constants.late, np.array(constants, dtype=np.float64)
        self._start_variances = (constants.var_position, constants.var_position, constants.var_heading)
        placed = scenario.robots.poses is None and scenario.robots.start_noise.position < FAR
        noise = scenario.robots.start_noise
        near = (math.hypot(IN_PLACE, noise.position), math.hypot(IN_LINE, noise.heading))
        slots = task.block(0)[0].slots[0, : self.blocks]
        self.memory: FlatWindow = start(slots, np.tile(near if placed else (FAR, TURNED), (self.blocks, 1)))
        """The state, as compiled code takes it."""
        self._knows = placed and body.age > 0
        self._begun, self._rolled, self._until = False, False, 0
        self._speed = STILL
        self._results = np.empty(RESULTS)

    @property
    def window(self) -> Window:
        """The state field by field: views of the memory."""
        return view(self.memory)

    def reshape(self) -> None:
        if not self._begun:
            for mean in (self.window.base_mean, self.window.copy_mean):
                mean[:, :3] = self._task.block(0)[0].slots[0, : self.blocks]

    def begin(self, speed: FloatArray) -> None:
        self._begun, self._speed = True, speed

    def roll(self, k: int, speed: FloatArray, measurement: Measurement | None = None) -> None:
        motors = self._motors
        if not self._rolled and k > 1:  # the agent begins in the middle of an episode
            self._knows = False
            self.window.sums[0, 2] = k - 1
        learns, knows = self._rolled and motors.learns, self._knows
        tick, located, pose, related, relative = (
            self._sensed(measurement) if measurement is not None and knows else UNMEASURED
        )
        (real, whole), before, dt = self.memory, self._speed, self._dt
        if estimation.roll(
            real, whole, motors.memory, k, before, speed, dt, learns, tick, located, pose, related, relative
        ):
            motors.learnt()
        self._begun, self._rolled, self._until, self._speed = True, True, k, speed
        if measurement is not None and not knows:
            self.sense(measurement)

    def sense(self, measurement: Measurement) -> None:
        pose = measurement.pose
        if pose is not None and not self._knows and measurement.tick >= self._until - LENGTH:
            self._begin(measurement.tick, pose)
            return
        estimation.sense(*self.memory, *self._sensed(measurement))

    def _sensed(self, measurement: Measurement) -> tuple[int, bool, FloatArray, bool, FloatArray]:
        """A measurement as compiled code takes it."""
        tick, pose, relative = measurement
        located, related = pose is not None, relative is not None and self.sees
        return tick, located, NOWHERE if pose is None else pose, related, STILL if relative is None else relative

    def _begin(self, tick: int, pose: FloatArray) -> None:
        """The first localisation is where the filter starts."""
        window = self.window
        self._knows = True
        window.base_tick[0] = window.newest[0] = tick
        table = self._task.table(tick)
        window.base_mean[:, :3] = table.slots[tick - table.first, : self.blocks]
        window.base_mean[0, :3] = pose
        if tick > 0:  # the neighbours may be anywhere
            for h in range(1, self.blocks):
                for axis, sigma in enumerate((FAR, FAR, TURNED)):
                    window.base_cov[6 * h + axis, 6 * h + axis] = sigma**2
        for axis, variance in enumerate(self._start_variances):
            window.base_cov[axis, axis] = variance

    def estimate(self, k: int, heard: Plan | None) -> Estimate | None:
        if not self._knows:
            return None
        task, motors, hops = self._task, self._motors, self.blocks - 1
        table = task.table(k)
        late = table if task.lag == 0.0 else task.table(math.floor(k - task.lag / self._dt))
        out, covariance = np.empty(RESULTS), np.empty((3, 3))
        odometry, rows = (np.empty((hops, 4)), np.empty((hops * KEPT, COLUMNS))) if hops else NOT_PASSED
        begins, interval, inputs, twist, disturbance = SILENCE
        if heard is not None:
            begins, interval, inputs = heard.stamp + heard.delay, heard.interval, heard.inputs
            twist, disturbance = heard.twist, heard.disturbance
        (real, whole), (slots, ways, first), (late_slots, late_ways, late_first) = self.memory, table, late
        used, rejected, alarm = estimation.estimate(
            real,
            whole,
            motors.memory,
            self._tuning,
            slots,
            ways,
            first,
            late_slots,
            late_ways,
            late_first,
            task.lag,
            begins,
            interval,
            inputs,
            twist,
            disturbance,
            k,
            motors.delay,
            motors.rate,
            self._mode,
            self._ring,
            self._speed,
            out,
            covariance,
            odometry,
            rows,
        )
        self._results = out
        return _make_estimate(
            out[POSE],
            out[SPEED],
            out[TWIST],
            out[DISTURBANCE],
            covariance,
            rejected,
            (k - self._late - alarm) * self._dt,
            out[INPUT_DISTURBANCE],
            out[DRIFT],
            out.item(DRIFT_SIGMA),
            odometry,
            rows[:used] if hops else rows,
        )

    def neighbour(self) -> tuple[FloatArray, FloatArray]:
        return self._results[NEIGHBOUR], self._results[NEIGHBOUR_DRIFT]

    def hear(self, plan: Plan) -> None:
        """The upstream neighbour's measurements, from its newest plan."""
        if self.blocks > 1 and self._mode == HEARD and len(plan.odometry):
            estimation.take(*self.memory, plan.odometry, plan.measurements, self._dt)
