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
from agents.kernels.best_response import plan_response
from agents.kernels.planner import planner
from agents.kernels.response import lag_of
from agents.kernels.waiting import FRESH
from formation.arrays import FloatArray
from network.values import NO_NEWS, tuple_maker

_make_solution = tuple_maker(Solution)


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
        self._task, self._waiting, self._row = task, waiting, task.robot - 1
        self._step = task.every * task.tick
        times = self._step, task.tick, task.interval, task.stride
        constants = weights.own, spacing**2, spacing, sources, weights.trust_time, *times
        costs = weights.speed / spacing**2, weights.turn
        self._planner = planner(constants, costs, task.limits, task.horizon)
        self._memory = waiting.memory if waiting else waiting_state.start(1, task.horizon)
        self._robots = int(self._memory.whole[0])  # of which a plan may tell news
        self._motor_lag, self._lag = 0.0, lag_of(0.0, task.interval)

    def plan(self, observation: Observation) -> Solution:
        task, waiting, lost = self._task, self._waiting, observation.lost
        if waiting and lost:
            waiting.lose(observation.k)
        elif waiting and observation.kept_off is not None:
            waiting.let_be(observation.kept_off, observation.k)
        out, news = np.empty((2, task.horizon, 2)), np.empty((self._robots, 4))
        attends = waiting is not None and not lost
        found = self._respond(observation, out, news, attends=attends, waits=False)
        if not found[0]:
            _, task.lag, task.pace, waits, *_ = found
            found = self._respond(observation, out, news, attends=False, waits=waits)
        _, lag, _, _, converged, rate, waits, known = found
        if waiting is None:
            return Solution(out[0], converged, motion=out[1])
        return _make_solution(out[0], converged, lag, rate, waits, news if known == len(news) else news[:known], out[1])

    def _respond(
        self, observation: Observation, out: FloatArray, news: FloatArray, *, attends: bool, waits: bool
    ) -> tuple[bool, float, float, bool, bool, float, bool, int]:
        """The plan as plan_response makes it, or no plan but another lag and pace."""
        (
            k,
            pose,
            up,
            down,
            speed,
            disturbance,
            covariance,
            alarm_age,
            rejected,
            gap,
            lag,
            _,
            lost,
            noise,
            bodies,
            _,
            _,
        ) = observation
        task, at, (real, whole) = self._task, float(k), self._memory
        block, row = task.begin(k)
        slots, inputs = block.slots, block.inputs
        table_slots, table_inputs, first = slots, inputs, block.first
        if attends and (task.lag != 0.0 or task.pace != 1.0):
            at = max(k - (task.lag + (1.0 - task.pace) * self._step) / task.tick, 0.0)
            table_slots, table_inputs, first = task.table(math.floor(at + 1e-9))
        if lag != self._motor_lag:
            self._motor_lag, self._lag = lag, lag_of(lag, task.interval)
        keep, blend = self._lag
        up_inputs, up_news, up_trusted, up_waits = self._heard(up, k, lost=lost)
        down_news, down_trusted, down_waits, down_inputs = NO_NEWS, False, False, up_inputs
        if down is None:
            down = up
        else:
            down_inputs, down_news, down_trusted, down_waits = self._heard(down, k, lost=lost)
        found: tuple[bool, float, float, bool, bool, float, bool, int] = plan_response(
            real,
            whole,
            self._planner,
            slots,
            inputs,
            row,
            task.lag,
            task.pace,
            attends,
            waits,
            self._row,
            table_slots,
            table_inputs,
            first,
            at,
            k,
            pose,
            speed,
            disturbance,
            noise,
            covariance,
            rejected,
            gap,
            alarm_age,
            keep,
            blend,
            up.pose,
            up_inputs,
            up.drift,
            up_news,
            up.age,
            up.seen,
            up_trusted,
            up_waits,
            down.pose,
            down_inputs,
            down.drift,
            down_news,
            down.age,
            down.seen,
            down_trusted,
            down_waits,
            bodies,
            out,
            news,
        )
        return found

    def _heard(self, neighbour: NeighborEstimate, k: int, *, lost: bool) -> tuple[FloatArray, FloatArray, bool, bool]:
        """A neighbour's inputs, the news of its plan, whether an edge to it means something, whether it waits."""
        inputs, plan = np.ascontiguousarray(neighbour.inputs), neighbour.plan
        if plan is None:
            return inputs, NO_NEWS, True, False
        # Of two robots that follow different references, an edge between them means nothing.
        waits = plan.waits and k * self._task.tick - (plan.stamp + plan.delay) < FRESH
        return inputs, plan.news, (plan.lost > 0) == lost, waits
