"""The window filter of one robot: raw measurements in, an estimate out (docs/theory.md, section 12)."""

import math

import numpy as np

from agents.controllers.task import Task
from agents.estimator import STILL, Estimate, Measurement
from agents.kernels.look_ahead import look_ahead, neighbour_ahead
from agents.kernels.window_filter import Heard, hear, newest_rows, update
from agents.kernels.window_state import HEARD, LENGTH, SIGHT, Tuning, Window, start, tuning
from agents.motor_model import MotorModel
from formation.arrays import FloatArray
from formation.scenario.scenario import Scenario
from network.messages import Plan
from network.values import NO_MEASUREMENTS, NO_SUMS

FAR, TURNED = 0.5, 1.0
"""Standard deviations of where a neighbour is believed to start if robots do not start in formation [m, rad]."""
IN_PLACE, IN_LINE = 0.001, 0.01
"""The same if they do."""


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
        self.blocks = min(wish.window, scenario.size) if self.sees else 1
        """W, robots in the window."""
        self._task, self._motors, self._dt = task, motors, scenario.control_interval
        self._ring = scenario.size
        self._mode = HEARD if listens else SIGHT
        self._tuning: Tuning = tuning(body, self._dt, sees=self.sees, detects=wish.disturbances)
        self._compensates = wish.disturbances
        placed = scenario.robots.poses is None and scenario.robots.start_noise.position < FAR
        noise = scenario.robots.start_noise
        near = (math.hypot(IN_PLACE, noise.position), math.hypot(IN_LINE, noise.heading))
        slots = task.block(0)[0].slots[0, : self.blocks]
        self.window: Window = start(slots, np.tile(near if placed else (FAR, TURNED), (self.blocks, 1)))
        self._knows = placed and body.age > 0
        self._rolled = False
        self._speed = STILL
        self._heard: tuple[int, Heard] | None = None
        self._silent = Heard(False, 0.0, 1.0, np.zeros((1, 2)), STILL, STILL)

    def begin(self, speed: FloatArray) -> None:
        self._speed = speed

    def roll(self, k: int, speed: FloatArray) -> None:
        if self._rolled:
            self._motors.observe(k - 1, self._speed, speed)
        elif k > 1:  # the agent begins in the middle of an episode
            self._knows = False
            self.window.sums[0, 2] = k - 1
        self._rolled = True
        self._speed = speed
        window, row, v, omega = self.window, (k - 1) % LENGTH, speed[0], speed[1]
        window.odometry[0, row, 0], window.odometry[0, row, 1] = v, omega
        window.sums[0, 0] += v * self._dt
        window.sums[0, 1] += omega * self._dt
        window.until[0] = k

    def sense(self, measurement: Measurement) -> None:
        window, tick = self.window, measurement.tick
        row = tick % LENGTH
        if tick < window.until[0] - LENGTH:
            return
        if measurement.pose is not None and tick >= window.localised_at[0, row]:
            if not self._knows:
                self._begin(tick, measurement.pose)
                return
            window.localised[0, row] = measurement.pose
            window.localised_at[0, row] = tick
            window.newest[0] = max(window.newest[0], tick)
        if measurement.relative is not None and self.sees and tick >= window.related_at[0, row]:
            window.related[0, row] = measurement.relative
            window.related_at[0, row] = tick
            window.newest[0] = max(window.newest[0], tick)

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
        for axis, variance in enumerate((self._tuning.var_position,) * 2 + (self._tuning.var_heading,)):
            window.base_cov[axis, axis] = variance

    def estimate(self, k: int, heard: Plan | None) -> Estimate | None:
        if not self._knows:
            return None
        task, motors, window = self._task, self._motors, self.window
        plan = self._plan(k, heard)
        here, late = task.table(k), task.table(math.floor(k - task.lag / self._dt))
        update(window, here, late, task.lag, plan, self._mode, self._ring, self._tuning)
        pose, speed, twist = np.empty(3), self._speed.copy(), np.empty(2)
        look_ahead(
            window,
            motors.commands,
            k,
            motors.delay,
            motors.rate,
            motors.change,
            motors.limits,
            self._dt,
            pose,
            speed,
            twist,
        )
        alarm = (k - self._tuning.late - int(window.alarm[0])) * self._dt
        rejected = int(window.copy_rejected[0, 0])
        disturbance, covariance = window.copy_mean[0, 3:].copy(), window.copy_cov[:3, :3].copy()
        return Estimate(pose, speed, twist, disturbance, covariance, rejected, alarm)

    def neighbour(self, k: int, heard: Plan | None) -> tuple[FloatArray, FloatArray]:
        """The upstream neighbour at tick k as it is seen: pose (3,), and drift (2,) in the world frame [m/s].

        After `estimate` of the same tick; only if `sees`.
        """
        pose = np.empty(3)
        here = self._task.table(k)
        neighbour_ahead(self.window, k, here, self._plan(k, heard), self._dt, pose)
        lateral = float(self.window.copy_mean[1, 4])
        return pose, np.array([-lateral * math.sin(pose[2]), lateral * math.cos(pose[2])])

    def hear(self, plan: Plan) -> None:
        """The upstream neighbour's measurements, from its newest plan."""
        if self.blocks > 1 and self._mode == HEARD and len(plan.odometry):
            hear(self.window, plan.odometry, plan.measurements, self._dt)

    def odometry(self) -> FloatArray:
        """(H, 4) what `Plan.odometry` carries."""
        hops = self.blocks - 1
        if hops < 1:
            return NO_SUMS
        window = self.window
        return np.column_stack([window.sums[:hops, :2], window.until[:hops], window.sums[:hops, 2]])

    def measurements(self) -> FloatArray:
        """(m, 9) what `Plan.measurements` carries."""
        return newest_rows(self.window, self.blocks - 1) if self.blocks > 1 else NO_MEASUREMENTS

    def _plan(self, k: int, heard: Plan | None) -> Heard:
        """What compiled code is told of the newest plan."""
        if heard is None:
            return self._silent
        dt = self._dt
        here = (k + self._motors.delay) * dt - heard.begins < len(heard.inputs) * heard.interval
        arrays = (heard.inputs.copy(), heard.twist.copy(), heard.disturbance.copy())  # decoded ones are read-only
        return Heard(here, heard.begins / dt, heard.interval / dt, *arrays)
