"""Stick together: how far a robot is behind the clock along its path, agreed on round the ring.

A robot's reference is the scenario's at its own reference time, t - lag. Who falls behind its slot because it does not
move as it planned holds its reference time back; its next plan carries `lag` and `lag_rate` (the rate at which it lets
its lag change), and who receives that holds back as well. Once everybody is in place again, all lags are worked off
together, as fast as the robots' limits allow. Without trouble every lag is exactly zero, and the reference is the
scenario's. (Who is behind for another reason, say a corner that nobody can follow, only gets worse by standing still.)

A lag is only ever pulled up to one that a robot had, plus what that robot itself was about to add while its plan
travelled. What a robot adds because it was pulled is not extrapolated: round a ring, with delays, that would feed
itself.
"""

import math

import numpy as np

from agents.controllers.pair import Pair
from agents.kernels.unicycle import age
from formation.arrays import FloatArray
from network.messages import Plan

FREE = 0.05
"""A robot may be so many spacings behind its slot before it holds its reference time back."""
WIDTH = 0.05
"""So many spacings further behind, its reference time stands still."""
PULL = 20.0
"""How fast a lag is pulled up to the neighbour's [1/s]."""
REVERSE = 1.0
"""A pulled robot's reference time runs backwards at most this fast."""
HASTE = 0.5
"""Lags are worked off at most at this rate."""
MARGIN = 0.95
"""Share of the speed limit that may be used for working off a lag."""
SETTLE = 1.0
"""Time constant with which the last of a lag is worked off [s]."""
MEMORY = 2.0
"""Time constant with which a robot forgets that it did not move as planned [s]."""
LEAST = 1e-4
"""A lag below this is none [s]."""


class Progress:
    """The lag of one robot, from planning tick to planning tick."""

    def __init__(self, pair: Pair, spacing: float) -> None:
        """A robot on time.

        Args:
            pair: its task.
            spacing: of the formation [m].
        """
        self._pair, self._spacing = pair, spacing
        self._k = 0
        self._short = 0.0
        self._planned: tuple[FloatArray, FloatArray] | None = None
        self.lag_rate = 0.0
        """Rate at which the robot itself lets its lag change."""

    def update(self, k: int, pose: FloatArray, plan: Plan | None) -> None:
        """Bring the pair's lag and pace to tick k.

        Args:
            k: planning tick.
            pose: (3,) of the robot now.
            plan: the newest of its upstream neighbour.
        """
        pair = self._pair
        elapsed, self._k = (k - self._k) * pair.tick, k
        slot, speed = pair.target(k)
        forward = math.copysign(1.0, speed)
        behind = min(forward * _along(slot[2], slot - pose), forward * self._shortfall(pose, elapsed))
        hold = min(max((behind / self._spacing - FREE) / WIDTH, 0.0), 1.0)
        self.lag_rate = hold - (1.0 - hold) * min(self._haste(speed), pair.lag / SETTLE)
        change = elapsed * self.lag_rate
        ahead = self._others(k, plan) - pair.lag
        if ahead > 0.0:
            change += min(PULL * elapsed, 1.0) * ahead
        change = min(change, (1.0 + REVERSE) * elapsed)
        lag = min(max(pair.lag + change, 0.0), k * pair.tick)
        lag = 0.0 if lag < LEAST and hold == 0.0 else lag
        pace = 1.0 - (lag - pair.lag) / elapsed if elapsed > 0.0 else 1.0
        pair.lag, pair.pace = lag, min(max(pace, 0.0), 1.0 + HASTE)

    def planned(self, pose: FloatArray, inputs: FloatArray) -> None:
        """What the robot is going to do from its pose (3,) now: inputs (N, 2)."""
        self._planned = pose, inputs

    def _shortfall(self, pose: FloatArray, elapsed: float) -> float:
        """By how much it did not get as far as it had planned, lately [m]."""
        self._short *= math.exp(-elapsed / MEMORY)
        if self._planned is not None:
            expected = np.empty(3)
            age(*self._planned, elapsed, self._pair.interval, expected)
            self._short += _along(pose[2], expected - pose)
        return self._short

    def _haste(self, speed: float) -> float:
        """Rate at which the own limits allow to work a lag off, from the speed of the slot [m/s]."""
        return min(max(MARGIN * float(self._pair.limits[0]) / max(abs(speed), 1e-9) - 1.0, 0.0), HASTE)

    def _others(self, k: int, plan: Plan | None) -> float:
        """The neighbour's lag by now, as far as its newest plan tells."""
        if plan is None:
            return 0.0
        age = k * self._pair.tick - plan.stamp
        return plan.lag + plan.lag_rate * age if age < len(plan.inputs) * plan.interval else 0.0


def _along(theta: float, gap: FloatArray) -> float:
    """The part of a gap (x, y, ...) that lies in the direction theta."""
    return float(math.cos(theta) * gap[0] + math.sin(theta) * gap[1])
