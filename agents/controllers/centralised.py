"""Controller `centralised`: one planner for all robots, which knows their true poses; a reference, not a bound.

At every planning tick it sees the true poses of all robots and minimises the sum over the ring of the costs J_i that
`nash` plays for, jointly, to convergence and within the limits. No plans of the same horizon cost less in that sum;
a controller with other aims may still hold the pattern better and the path worse. For robots that cannot keep up it
waits by the rule of agents/controllers/pair_waiting.py, with one lag for all. If commands act late, it plans from where
robots will be by then, along the commands that are under way. The plans that its agents exchange are not used. It runs
in one process only (runtime/inprocess.py). docs/theory.md, section 7 says why it is not a bound.
"""

import math
from collections import deque

import numpy as np

from agents.controllers.interface import Observation, Solution
from agents.controllers.pair_game import pair_game, weights
from agents.controllers.pair_waiting import PairWaiting
from agents.controllers.task import Task
from agents.kernels.learning import view
from agents.kernels.lq import optimise
from agents.kernels.pair_cost import ring_weights
from agents.kernels.unicycle import shift
from agents.motor_model import MotorModel
from formation import unicycle
from formation.arrays import FloatArray
from formation.scenario.scenario import Scenario

STEPS = 50
"""At most so many Gauss-Newton steps per plan; in formation one or two are enough."""
TOLERANCE = 1e-6
"""Largest change of an input at which a plan has converged [m/s, rad/s]."""


class Team:
    """The planner of all robots for one episode. The first member that asks at a tick triggers the solve for all."""

    def __init__(self, scenario: Scenario) -> None:
        self._tasks = [Task(scenario, robot) for robot in range(1, scenario.size + 1)]
        self._waiting = [PairWaiting(task, scenario.spacing) for task in self._tasks]
        self._waits = pair_game(scenario).waits
        q, r = weights(scenario)
        self._q, self._r = np.array(q, dtype=float), np.tile(np.array(r, dtype=float), scenario.size)
        self._motors = MotorModel(scenario, self._tasks[0].limits)
        delay = self._motors.delay
        self._under_way: deque[FloatArray] = deque(scenario.start.inputs[:delay], maxlen=delay)
        """Commands (n, 2) that have no effect yet, the oldest first; robots start in motion [m/s, rad/s]."""
        self._now: tuple[int, FloatArray] | None = None
        self._plan: tuple[int, FloatArray, bool] | None = None

    def see(self, k: int, poses: FloatArray, speeds: FloatArray, commands: FloatArray) -> None:
        if k > 0:
            self._under_way.append(np.array(commands, dtype=float))
        at = k + self._motors.delay
        self._now = at, self._carried(poses, speeds)

    def _carried(self, poses: FloatArray, speeds: FloatArray) -> FloatArray:
        """Poses (n, 3) once the commands under way have had their effect, as nominal bodies follow them."""
        here, wheels = np.array(poses, dtype=float), np.array(speeds, dtype=float)
        motors, tick = view(self._motors.memory), self._tasks[0].tick
        for acting in self._under_way:
            gap = np.clip(acting, -motors.limits, motors.limits) - wheels
            wheels += np.clip(self._motors.rate * gap, -motors.change, motors.change)
            moved = [unicycle.step(x, y, theta, v, omega, tick) for x, y, theta, v, omega in np.hstack([here, wheels])]
            here = np.array(moved)
        return here

    def reshape(self, scenario: Scenario, k: int) -> None:
        """From tick k on the formation has the offsets of this scenario."""
        for task in self._tasks:
            task.reshape(scenario, k)

    def member(self, robot: int) -> "Member":
        """The controller of one robot."""
        return Member(self, robot)

    @property
    def lag(self) -> float:
        """How far the formation's reference time is behind the clock [s]."""
        return self._tasks[0].lag

    def plan(self, k: int) -> tuple[FloatArray, bool]:
        """Inputs (N, n, 2) of all, which have an effect from tick k on, and whether they could be found.

        Solved once per tick. Raises RuntimeError if it was not shown the tick at which they are commanded.
        """
        if self._plan is None or self._plan[0] != k:
            if self._now is None or self._now[0] != k:
                now = k - self._motors.delay
                raise RuntimeError(f"expected to be shown the poses of tick {now} before planning")
            self._plan = (k, *self._solve(k, self._now[1]))
        return self._plan[1:]

    def problem(self, k: int) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray, float]:
        """Slots (N + 1, n, 3), their inputs (N, n, 2), weights (N + 1, 3n, 3n), R and Delta_T, for the kernels."""
        ahead = [task.ahead(k) for task in self._tasks]
        slots = np.stack([one.slots[:, 0] for one in ahead], axis=1)
        targets = np.stack([one.inputs[:, 0] for one in ahead], axis=1)
        costs = np.empty((len(slots), 3 * len(ahead), 3 * len(ahead)))
        ring_weights(slots, self._q, costs)
        return slots, targets, costs, self._r, self._tasks[0].interval

    def _solve(self, k: int, poses: FloatArray) -> tuple[FloatArray, bool]:
        if self._waits:
            self._wait(k, poses)
        problem, limits, tick = self.problem(k), self._tasks[0].limits, self._tasks[0].tick
        targets, interval = problem[1], problem[4]
        nominal = targets.copy()
        if self._plan is not None:
            made, last, _ = self._plan
            for robot in range(len(poses)):
                shift(last[:, robot], (k - made) * tick, interval, targets[:, robot], nominal[:, robot])
        out = np.empty((len(targets), 2 * len(poses)))
        change = optimise(poses.ravel(), nominal.reshape(out.shape), *problem, limits, STEPS, TOLERANCE, out)
        converged = math.isfinite(change)
        inputs = out.reshape(nominal.shape) if converged else np.clip(np.nan_to_num(nominal), -limits, limits)
        for robot, progress in enumerate(self._waiting):
            progress.planned(poses[robot], np.ascontiguousarray(inputs[:, robot]))
        return inputs, converged

    def _wait(self, k: int, poses: FloatArray) -> None:
        """Give every robot the lag of the one that is furthest behind."""
        for progress, pose in zip(self._waiting, poses, strict=True):
            progress.update(k, pose, None)
        lag, pace = max(task.lag for task in self._tasks), min(task.pace for task in self._tasks)
        for task in self._tasks:
            task.lag, task.pace = lag, pace


class Member:
    """One robot's part of the team's plan."""

    def __init__(self, team: Team, robot: int) -> None:
        self._team, self._robot = team, robot

    def plan(self, observation: Observation) -> Solution:
        inputs, converged = self._team.plan(observation.k)
        return Solution(np.ascontiguousarray(inputs[:, self._robot - 1]), converged, self._team.lag)
