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
from agents.controllers.task import Task
from agents.controllers.waiting import Waiting
from agents.kernels import waiting_state
from agents.kernels.best_response import WORK_COLUMNS, plan_response
from agents.kernels.response import lag_of

SHARED = 0.25
"""Weight of the own slot while neighbours are trusted, as a share of that without."""
ALARM_TIME, ALARM_MEMORY, ALARM_LEAST = 0.1, 0.5, 0.1
"""While the own robot is newly disturbed, trust fades with this time constant; for how long that holds [s]."""
SIGHT_TIME, SIGHT_LEAST = 0.6, 0.3
"""Trust in a neighbour that is seen: how fast it fades [s], and what is left of it."""
WAIT_TIME = 0.05
"""While anybody waits, trust fades with this time constant: a stuck robot's plan is wrong [s]."""


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
        self._last = np.zeros((task.horizon, 2))
        self._begun = False
        self._step = task.every * task.tick
        self._memory = waiting.memory if waiting else waiting_state.start(1, task.horizon)

    def plan(self, observation: Observation) -> Solution:
        task, weights, square = self._task, self._weights, self._spacing**2
        waits = False
        if self._waiting and observation.lost:
            self._waiting.lose(observation.k)
        elif self._waiting:
            waits = self._waiting.update(observation)
        ahead = task.ahead(observation.k)
        up, down = observation.upstream, observation.downstream
        f, g = self._trust(observation, up, waiting=waits), self._trust(observation, down, waiting=waits)
        trust = f / max(self._sources, 1) + g / max(self._sources, 1)
        place = weights.own * (SHARED + (1.0 - trust) * (1.0 - SHARED)) / square
        other = down or up
        inputs, motion = np.empty((task.horizon, 2)), np.empty((task.horizon, 2))
        news = np.empty((int(self._memory.whole[0]), 4))
        converged, rate, waits, known = plan_response(
            *self._memory,
            ahead.slots,
            ahead.inputs,
            observation.pose,
            observation.speed,
            observation.disturbance,
            f * weights.own / square,
            up.pose,
            np.ascontiguousarray(up.inputs),
            up.drift,
            g * weights.own / square,
            other.pose,
            np.ascontiguousarray(other.inputs),
            other.drift,
            place,
            self._costs,
            task.limits,
            *lag_of(observation.motor_lag, task.interval),
            task.interval,
            self._step,
            self._begun,
            self._last,
            self._work,
            inputs,
            motion,
            news,
        )
        self._last, self._begun = inputs, True
        if self._waiting is None:
            return Solution(inputs, converged, motion=motion)
        return Solution(inputs, converged, task.lag, rate, waits, news[:known], motion)

    def _trust(self, observation: Observation, neighbour: NeighborEstimate | None, *, waiting: bool) -> float:
        """f_q of one neighbour."""
        if neighbour is None:
            return 0.0
        if neighbour.plan is not None and (neighbour.plan.lost > 0) != observation.lost:
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
