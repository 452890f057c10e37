"""Best response along the edges: own inputs, against the plans that were received (docs/theory.md, section 14).

Each robot minimises, over its own inputs alone,

    J_i = sum_j [ S_f |e|^2 / 2 + sum_q f_q s (d_q . (e - e_q))^2 / 2 + psi^2 / 2 ] + inputs R / 2,

with e = slot - pose, d_q the unit vector from the own slot to that of neighbour q, e_q the neighbour's error along its
aged plan, and psi the heading error. f_q, the trust in a neighbour's plan, fades with the plan's age; with no trust the
robot follows its own slot with weight S_0, which is `virtual_structure`. With both ring neighbours the J_i share a
potential, and a fixed point of everybody's responses is a Nash equilibrium of all robots.
"""

import math
from dataclasses import dataclass

import numpy as np

from agents.controllers.interface import NeighborEstimate, Observation, Solution
from agents.controllers.task import HorizonReference, Task
from agents.controllers.waiting import Waiting
from agents.kernels.edges import errors_along
from agents.kernels.response import Stage, Targets, lag_of, respond
from agents.kernels.unicycle import shift
from formation.arrays import FloatArray

SHARED = 0.25
"""Weight of the own slot while neighbours are trusted, as a share of that without."""
ALARM_TIME, ALARM_MEMORY, ALARM_LEAST = 0.1, 0.5, 0.1
"""While the own robot is newly disturbed, trust fades with this time constant; for how long that holds [s]."""
SIGHT_TIME, SIGHT_LEAST = 0.6, 0.3
"""Trust in a neighbour that is seen: how fast it fades [s], and what is left of it."""
WAIT_TIME = 0.05
"""While anybody waits, trust fades with this time constant: a stuck robot's plan is wrong [s]."""
SLOW = 0.01
"""Speed of a slot below which its heading is not turned against a drift [m/s]."""
WORK_COLUMNS = 24


@dataclass(frozen=True, slots=True)
class Weights:
    """What the cost is made of; lengths count in spacings."""

    own: float = 120.0
    """S_0 = s: of the own slot without trust, and of an edge."""
    speed: float = 0.01
    """R of a speed of one spacing per second beyond the slot's."""
    turn: float = 0.4
    """R of a turn rate of 1 rad/s beyond the slot's."""
    trust_time: float = 0.3
    """Time constant with which trust in a plan fades with its age [s]."""


class BestResponse:
    """The controller of one robot."""

    def __init__(self, task: Task, spacing: float, weights: Weights, waiting: Waiting | None, *, sources: int) -> None:
        """A robot that has not planned yet.

        Args:
            task: its task.
            spacing: of the formation [m].
            weights: of its cost.
            waiting: how it waits for others; None: never.
            sources: neighbours whose plans it hears: 0, 1 or 2. An edge to a neighbour that is seen it holds anyway.
        """
        self._task, self._spacing, self._weights, self._waiting = task, spacing, weights, waiting
        self._sources = sources
        self._costs = np.array([weights.speed / spacing**2, weights.turn])
        self._work = np.empty((task.horizon + 1, WORK_COLUMNS))
        self._last: FloatArray | None = None
        self._step = task.every * task.tick

    def plan(self, observation: Observation) -> Solution:
        task, weights = self._task, self._weights
        neighbours = (observation.upstream, observation.downstream)
        waiting = False
        if self._waiting and observation.lost:
            self._waiting.rest(observation.k)
        elif self._waiting:
            waiting = self._waiting.update(observation)
        ahead = task.ahead(observation.k)
        slots = np.ascontiguousarray(ahead.slots[:, 0])
        targets = np.ascontiguousarray(ahead.inputs[:, 0])
        steps = len(targets)
        direction, error = np.zeros((2, steps + 1, 2)), np.zeros((2, steps + 1))
        edge, trust = np.zeros(2), 0.0
        for side, neighbour in enumerate(neighbours):
            f = self._trust(observation, neighbour, waiting=waiting)
            if neighbour is None or f == 0.0:
                continue
            trust += f / max(self._sources, 1)
            edge[side] = f * weights.own / self._spacing**2
            self._edge(ahead, neighbour, task.columns_of_sides[side], slots, direction[side], error[side])
        place = weights.own * (SHARED + (1.0 - trust) * (1.0 - SHARED)) / self._spacing**2
        drift = self._drift(observation)
        stage = Stage(place, edge, 1.0, self._costs, task.limits)
        turned = self._turned(slots, targets, float(observation.disturbance[1]))
        goals = Targets(turned, targets, direction, error, drift)
        inputs, motion = np.empty_like(targets), np.empty_like(targets)
        start = np.concatenate([observation.pose, observation.speed + observation.disturbance[[0, 2]]])
        nominal = self._nominal(targets)
        lag = lag_of(observation.motor_lag, task.interval)
        change = respond(start, nominal, goals, stage, lag, task.interval, self._work, inputs, motion)
        converged = math.isfinite(change)
        if not converged:
            inputs = motion = np.clip(np.nan_to_num(nominal), -task.limits, task.limits)
        self._last = inputs
        if self._waiting is None:
            return Solution(inputs, converged, motion=motion)
        said = self._waiting.planned(observation.pose, motion, drift)
        return Solution(inputs, converged, task.lag, said.rate, said.waits, said.news, said.motion)

    def _nominal(self, targets: FloatArray) -> FloatArray:
        """Inputs (N, 2) to linearise along: the last plan's, moved on."""
        if self._last is None:
            return targets.copy()
        nominal = np.empty_like(targets)
        shift(self._last, self._step, self._task.interval, targets, nominal)
        return nominal

    def _trust(self, observation: Observation, neighbour: NeighborEstimate | None, *, waiting: bool) -> float:
        """f_q of one neighbour."""
        if neighbour is None:
            return 0.0
        if neighbour.plan is not None and neighbour.plan.lost != observation.lost:
            return 0.0  # they follow different references: an edge between them means nothing
        age = neighbour.age if self._sources else math.inf
        if not (neighbour.seen or math.isfinite(age)):
            return 0.0
        if neighbour.seen:
            f = max(SIGHT_LEAST, math.exp(-age / SIGHT_TIME))
        else:
            f = math.exp(-age / self._weights.trust_time)
            if math.exp(-observation.alarm_age / ALARM_MEMORY) >= ALARM_LEAST:
                f *= math.exp(-age / ALARM_TIME)
        return f * math.exp(-age / WAIT_TIME) if waiting else f

    def _edge(
        self,
        ahead: HorizonReference,
        neighbour: NeighborEstimate,
        column: int,
        slots: FloatArray,
        direction: FloatArray,
        error: FloatArray,
    ) -> None:
        """Direction (N + 1, 2) and error (N + 1,) along the edge to a neighbour."""
        other = ahead.slots[:, column]
        errors_along(
            neighbour.pose,
            np.ascontiguousarray(neighbour.inputs),
            neighbour.drift,
            other,
            slots,
            self._task.interval,
            direction,
            error,
        )

    def _drift(self, observation: Observation) -> FloatArray:
        """The own sideways drift in the world frame (2,) [m/s]."""
        lateral, theta = float(observation.disturbance[1]), float(observation.pose[2])
        return np.array([-lateral * math.sin(theta), lateral * math.cos(theta)])

    def _turned(self, slots: FloatArray, targets: FloatArray, lateral: float) -> FloatArray:
        """Slots (N + 1, 3) whose headings are turned against the drift, so that the robot moves along them."""
        if lateral == 0.0:
            return slots
        speed = targets[np.minimum(np.arange(len(slots)), len(targets) - 1), 0]
        moving = np.abs(speed) > SLOW
        turn = np.arctan(np.clip(lateral / np.where(moving, speed, 1.0), -0.5, 0.5))
        turned = slots.copy()
        turned[:, 2] -= np.where(moving, turn, 0.0)
        return turned
