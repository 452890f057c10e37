"""What a robot makes of its measurements: where it is now, where it will be when a command acts, what disturbs it.

Two estimators with one interface: `WindowEstimator` filters (docs/theory.md, section 12), `LatestPose` takes the newest
measured pose as it is, for controllers that are shown as they were printed.
"""

import math
from typing import NamedTuple, Protocol

import numpy as np

from agents.kernels.window.state import LENGTH
from formation import unicycle
from formation.arrays import FloatArray
from formation.scenario.scenario import Scenario
from network.messages import Plan, Tick
from network.values import NO_MEASUREMENTS, NO_SUMS, tuple_maker

STILL, NONE, CERTAIN = np.zeros(2), np.zeros(3), np.zeros((3, 3))


class Measurement(NamedTuple):
    """What sensors tell one robot at a tick."""

    tick: int
    """The tick that was measured."""
    pose: FloatArray | None
    """(3,) localised [m, m, rad]."""
    relative: FloatArray | None
    """(2,) position of the upstream neighbour in the own frame [m]."""


_make_measurement = tuple_maker(Measurement)


def measured(tick: Tick, row: int) -> Measurement:
    """What the sensors tell the robot of this row; they have measured."""
    assert tick.measured is not None
    delivers = len(tick.localised) == len(tick.poses) or row + 1 in tick.localised
    relative = tick.relatives[row] if len(tick.relatives) else None
    return _make_measurement(tick.measured, tick.poses[row] if delivers else None, relative)


class Estimate(NamedTuple):
    """A robot where its next plan begins."""

    pose: FloatArray
    """(3,) [m, m, rad]."""
    speed: FloatArray
    """(2,) of the wheels [m/s, rad/s]."""
    twist: FloatArray
    """(2,) mean body velocity from now to there [m/s, rad/s]."""
    disturbance: FloatArray
    """(3,) body velocity that no command makes: forward, lateral [m/s], turn [rad/s]."""
    covariance: FloatArray
    """(3, 3) of the pose at the newest measurement."""
    rejected: int
    """Localisations rejected in a row."""
    alarm_age: float
    """Since a disturbance was last detected, by the stamp of the measurement [s]; inf if never."""
    input_disturbance: FloatArray
    """(2,) what of the disturbance a command can make good: of v and omega [m/s, rad/s]."""
    drift: FloatArray
    """(2,) what it cannot, the lateral part in the world frame [m/s]."""
    drift_sigma: float
    """Standard deviation of the lateral part [m/s]."""
    odometry: FloatArray
    """(H, 4) what `Plan.odometry` carries."""
    measurements: FloatArray
    """(m, 9) what `Plan.measurements` carries."""


class Estimator(Protocol):
    """Takes odometry and measurements tick by tick; says where the robot is."""

    def reshape(self) -> None:
        """The task's formation has other offsets from now on; if nothing was measured yet, robots begin in those."""
        ...

    def begin(self, speed: FloatArray) -> None:
        """Wheel speeds (2,) at tick 0."""
        ...

    def roll(self, k: int, speed: FloatArray, measurement: Measurement | None = None) -> None:
        """Odometry (2,) of tick k - 1, which has just ended, and what was measured then, if it came in with it."""
        ...

    def sense(self, measurement: Measurement) -> None:
        """A measurement came in."""
        ...

    @property
    def sees(self) -> bool:
        """Whether it knows the upstream neighbour by sight."""
        ...

    def hear(self, plan: Plan) -> None:
        """The newest plan of the upstream neighbour, for the measurements that it carries."""
        ...

    def neighbour(self) -> tuple[FloatArray, FloatArray]:
        """The upstream neighbour where the plan of the last estimate begins, as it is seen.

        Pose (3,), and drift (2,) in the world frame [m/s].
        """
        ...

    def estimate(self, k: int, heard: Plan | None) -> Estimate | None:
        """The robot where a plan made at tick k begins; None if it does not know where it is.

        Args:
            k: now.
            heard: the newest plan of the upstream neighbour.
        """
        ...


class LatestPose:
    """The newest measured pose as it is, carried on along odometry if it is late."""

    sees = False

    def __init__(self, scenario: Scenario) -> None:
        self._dt = scenario.control_interval
        self._newest: tuple[int, FloatArray] | None = None
        self._odometry = np.zeros((LENGTH, 2))
        self._speed = STILL

    def reshape(self) -> None:
        """Nothing: it begins with what is measured."""

    def begin(self, speed: FloatArray) -> None:
        self._speed = speed

    def roll(self, k: int, speed: FloatArray, measurement: Measurement | None = None) -> None:
        self._odometry[(k - 1) % LENGTH] = speed
        self._speed = speed
        if measurement is not None:
            self.sense(measurement)

    def sense(self, measurement: Measurement) -> None:
        if measurement.pose is not None and (self._newest is None or measurement.tick > self._newest[0]):
            self._newest = measurement.tick, measurement.pose

    def estimate(self, k: int, heard: Plan | None) -> Estimate | None:
        if self._newest is None or k - self._newest[0] >= LENGTH:
            return None
        tick, measured = self._newest
        pose = measured.copy()
        if tick < k:
            x, y, theta = pose
            for t in range(tick, k):
                v, omega = self._odometry[t % LENGTH]
                x, y, theta = unicycle.step(x, y, theta, v, omega, self._dt)
            pose = np.array([x, y, theta])
        speed, passed = self._speed, (NO_SUMS, NO_MEASUREMENTS)
        return Estimate(pose, speed, speed, NONE, CERTAIN, 0, math.inf, STILL, STILL, 0.0, *passed)

    def hear(self, plan: Plan) -> None:
        """Nothing: it does not filter."""

    def neighbour(self) -> tuple[FloatArray, FloatArray]:
        raise NotImplementedError("expected an estimator that sees")
