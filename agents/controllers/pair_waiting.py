"""Waiting: how far a robot's reference time is behind the clock, shared round the ring (docs/theory.md, section 6).

A robot's reference is the scenario's at its own reference time, t - lag. A robot that falls behind its slot because it
does not move as it planned holds its reference time back and sends this in its next plan (`lag`, and `lag_rate`, the
rate at which it changes its lag by itself); a robot that receives it holds back as well. Once all are in place again,
they reduce their lags together, as fast as their limits allow. If no robot falls behind, every lag is exactly zero, and
the reference is the scenario's. (A robot that is behind for another reason, such as a corner that it cannot follow,
would lose by waiting.)

A lag is only ever pulled up to one that another robot had, plus what that robot itself was about to add while its plan
travelled. What a robot adds because it was pulled is not extrapolated: round a ring with delays that would amplify
itself.
"""

import math

import numpy as np

from agents.controllers.task import Task
from agents.kernels.unicycle import age
from formation.arrays import FloatArray
from network.messages import Plan

FREE = 0.05
"""A robot holds its reference time back from this many spacings behind its slot on."""
WIDTH = 0.05
"""This many spacings further behind, its reference time stands still."""
PULL = 20.0
"""Rate at which a lag is pulled up to the neighbour's [1/s]."""
REVERSE = 1.0
"""Largest rate at which a pulled robot's reference time runs backwards."""
HASTE = 0.5
"""Largest rate at which a lag is reduced."""
MARGIN = 0.95
"""Share of the speed limit that is used to reduce a lag."""
SETTLE = 1.0
"""Time constant of the last part of a lag's reduction [s]."""
MEMORY = 2.0
"""Time constant with which a shortfall against the own plan decays [s]."""
LEAST = 1e-4
"""A lag below this is set to zero [s]."""


class PairWaiting:
    """The lag of one robot, from planning tick to planning tick."""

    def __init__(self, task: Task, spacing: float) -> None:
        """A robot without a lag.

        Args:
            task: its task.
            spacing: of the formation [m].
        """
        self._task, self._spacing = task, spacing
        self._k = 0
        self._short = 0.0
        self._planned: tuple[FloatArray, FloatArray] | None = None
        self.lag_rate = 0.0
        """Rate at which the robot changes its lag by itself; as in Plan."""

    def update(self, k: int, pose: FloatArray, plan: Plan | None) -> None:
        """Bring the pair's lag and pace to tick k.

        Args:
            k: planning tick.
            pose: (3,) of the robot now.
            plan: the newest of its upstream neighbour.
        """
        task = self._task
        elapsed, self._k = (k - self._k) * task.tick, k
        slot, speed = task.target(k)
        forward = math.copysign(1.0, speed)
        behind = min(forward * _along(slot[2], slot - pose), forward * self._shortfall(pose, elapsed))
        hold = min(max((behind / self._spacing - FREE) / WIDTH, 0.0), 1.0)
        self.lag_rate = hold - (1.0 - hold) * min(self._haste(speed), task.lag / SETTLE)
        change = elapsed * self.lag_rate
        ahead = self._others(k, plan) - task.lag
        if ahead > 0.0:
            change += min(PULL * elapsed, 1.0) * ahead
        change = min(change, (1.0 + REVERSE) * elapsed)
        lag = min(max(task.lag + change, 0.0), k * task.tick)
        lag = 0.0 if lag < LEAST and hold == 0.0 else lag
        pace = 1.0 - (lag - task.lag) / elapsed if elapsed > 0.0 else 1.0
        task.lag, task.pace = lag, min(max(pace, 0.0), 1.0 + HASTE)

    def planned(self, pose: FloatArray, inputs: FloatArray) -> None:
        """Record the new plan: inputs (N, 2) from the pose (3,) now."""
        self._planned = pose, inputs

    def _shortfall(self, pose: FloatArray, elapsed: float) -> float:
        """By how much it moved less than planned, with a memory of MEMORY seconds [m]."""
        self._short *= math.exp(-elapsed / MEMORY)
        if self._planned is not None:
            expected = np.empty(3)
            age(*self._planned, elapsed, self._task.interval, expected)
            self._short += _along(pose[2], expected - pose)
        return self._short

    def _haste(self, speed: float) -> float:
        """Rate at which the own limits allow to reduce a lag, from the speed of the slot [m/s]."""
        return min(max(MARGIN * float(self._task.limits[0]) / max(abs(speed), 1e-9) - 1.0, 0.0), HASTE)

    def _others(self, k: int, plan: Plan | None) -> float:
        """The neighbour's lag now, extrapolated from its newest plan [s]."""
        if plan is None:
            return 0.0
        age = k * self._task.tick - plan.stamp
        return plan.lag + plan.lag_rate * age if age < len(plan.inputs) * plan.interval else 0.0


def _along(theta: float, gap: FloatArray) -> float:
    """The part of a gap (x, y, ...) that lies in the direction theta."""
    return float(math.cos(theta) * gap[0] + math.sin(theta) * gap[1])
