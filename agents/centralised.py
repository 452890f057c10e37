"""Controller `centralised`: one mind plans for all robots with perfect knowledge, the bound for `nash`.

At every planning tick it sees the true poses of all robots and minimises the sum over the ring of the costs J_i that
`nash` plays for, jointly, to convergence and within the limits. No plans of the same horizon cost less in that sum;
a controller with other aims may still hold the pattern better and the path worse. What its agents send each other is
used by nobody. It exists within one process only (fleet/inprocess.py); over processes there is no such mind.
"""

import math

import numpy as np

from agents.kernels import shift
from agents.nash import Q, R
from agents.situation import Situation, Solution
from agents.team_kernel import optimise, ring_weights
from formation.arrays import FloatArray
from formation.scenario import Scenario

STEPS = 50
"""At most so many Gauss-Newton steps per plan; in formation one or two are enough."""
TOLERANCE = 1e-6
"""Largest change of an input at which a plan has converged [m/s, rad/s]."""


class Team:
    """The mind of all robots of one flight; the first who asks at a tick has it think, for everybody."""

    def __init__(self, scenario: Scenario) -> None:
        controller, limits = scenario.controller, scenario.robots.limits
        self._reference = scenario.reference()
        self._horizon, self._stride, self._robots = controller.horizon, scenario.stride, scenario.size
        self._tick, self._interval = scenario.control_interval, controller.prediction_interval
        self._limits = np.array([limits.v, limits.omega])
        self._q, self._r = np.array(controller.q or Q, dtype=float), np.array(controller.r or R, dtype=float)
        self._now: tuple[int, FloatArray] | None = None
        self._plan: tuple[int, FloatArray, bool] | None = None

    def see(self, k: int, poses: FloatArray) -> None:
        """The true poses (n, 3) at tick k, before anybody plans."""
        self._now = (k, poses)

    def member(self, robot: int) -> "Member":
        """The controller of one robot."""
        return Member(self, robot)

    def plan(self, k: int) -> tuple[FloatArray, bool]:
        """Inputs (N, n, 2) of all from tick k on, and whether they could be found; solved once per tick."""
        if self._plan is None or self._plan[0] != k:
            self._plan = (k, *self._solve(k))
        return self._plan[1:]

    def task(self, k: int) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray, float]:
        """Slots (N + 1, n, 3), their inputs (N, n, 2), weights (N + 1, 3n, 3n), R and Delta_T, for the kernels."""
        block, ahead = self._reference.block(k), self._stride * self._horizon
        row = k - block.first
        slots = np.ascontiguousarray(block.slots[row : row + ahead + 1 : self._stride])
        targets = np.ascontiguousarray(block.inputs[row : row + ahead : self._stride])
        weights = np.empty((len(slots), 3 * self._robots, 3 * self._robots))
        ring_weights(slots, self._q, weights)
        return slots, targets, weights, self._r, self._interval

    def _solve(self, k: int) -> tuple[FloatArray, bool]:
        if self._now is None or self._now[0] != k:
            raise RuntimeError(f"expected to be shown the poses of tick {k} before planning")
        task = self.task(k)
        targets = task[1]
        nominal = targets.copy()
        if self._plan is not None:
            made, last, _ = self._plan
            for robot in range(self._robots):
                elapsed = (k - made) * self._tick
                shift(last[:, robot], elapsed, self._interval, targets[:, robot], nominal[:, robot])
        out = np.empty((self._horizon, 2 * self._robots))
        poses = np.ascontiguousarray(self._now[1], dtype=float).ravel()
        change = optimise(poses, nominal.reshape(out.shape), *task, self._limits, STEPS, TOLERANCE, out)
        if not math.isfinite(change):
            return np.clip(np.nan_to_num(nominal), -self._limits, self._limits), False
        return out.reshape(nominal.shape), True


class Member:
    """One robot's part of the team's plan."""

    def __init__(self, team: Team, robot: int) -> None:
        self._team, self._robot = team, robot

    def plan(self, situation: Situation) -> Solution:
        inputs, converged = self._team.plan(situation.k)
        return Solution(np.ascontiguousarray(inputs[:, self._robot - 1]), converged)
