"""How a robot waits for those that cannot keep up, and says so (docs/theory.md, section 15)."""

import math
from typing import NamedTuple

import numpy as np

from agents.controllers.interface import NeighborEstimate, Observation
from agents.controllers.task import Task
from agents.kernels import waiting
from agents.kernels.waiting import AWAY, CARRIED_TICKS, FRESH, INTEGRAL, LAG, NEED, PACE, RATE, SHORT, WAITS, Self
from formation.arrays import FloatArray


class Said(NamedTuple):
    """What a plan says of waiting."""

    rate: float
    """At which the own need grows."""
    waits: bool
    """Whether the robot waits by its own need."""
    news: FloatArray
    """(m, 4) as in network.messages.Plan."""
    motion: FloatArray
    """(N, 2) mean body velocities, no faster than the robot got lately while it waits."""


class Waiting:
    """The waiting of one robot, from planning tick to planning tick; keeps its pair's lag and pace."""

    def __init__(self, task: Task, robot: int, robots: int, spacing: float) -> None:
        """A robot on time.

        Args:
            task: its task.
            robot: its number.
            robots: how many there are.
            spacing: of the formation [m].
        """
        self._task, self._row, self._spacing = task, robot - 1, spacing
        self.state = waiting.start(robots, task.horizon)
        self._step = task.every * task.tick

    def update(self, observation: Observation) -> bool:
        """Bring the pair's lag and pace to the observation; whether anybody waits, as far as is known."""
        task, state, at = self._task, self.state, float(observation.k)
        if observation.kept_off is not None:
            # What a robot was not let do is no reason to wait, nor to begin to soon after.
            state.velocities[:] = observation.kept_off
            if not state.whole[WAITS]:
                state.whole[AWAY] = max(int(state.whole[AWAY]), observation.k + CARRIED_TICKS)
        waits = False
        for neighbour in (observation.upstream, observation.downstream):
            waits |= self._hear(neighbour, at)
        c, s = math.cos(observation.pose[2]), math.sin(observation.pose[2])
        p = observation.covariance
        variance = c * c * p[0, 0] + 2.0 * c * s * p[0, 1] + s * s * p[1, 1]
        me = Self(
            self._row,
            at,
            observation.pose,
            math.sqrt(max(variance, 0.0)),
            float(observation.disturbance[0]),
            observation.rejected,
            observation.motor_gap,
        )
        late = (state.real[LAG] + (1.0 - state.real[PACE]) * self._step) / task.tick
        slot, rates = task.place(max(at - late, 0.0))
        waiting.decide(
            state, me, slot, rates, self._spacing, float(task.limits[0]), self._step, task.tick, task.interval
        )
        task.lag, task.pace = float(state.real[LAG]), float(state.real[PACE])
        return bool(waiting.somebody(state, self._row, at, waits, task.tick))

    def rest(self, k: int) -> None:
        """Declare no need at tick k: a lost robot would hold everybody back, and the clock runs on."""
        real, whole = self.state.real, self.state.whole
        real[NEED] = real[RATE] = real[INTEGRAL] = real[SHORT] = 0.0
        whole[WAITS] = 0
        self.state.news[self._row] = (0.0, 0.0, float(k))

    def _hear(self, neighbour: NeighborEstimate | None, at: float) -> bool:
        """Take a neighbour's news; whether its newest plan says that it waits."""
        if neighbour is None or neighbour.plan is None:
            return False
        plan = neighbour.plan
        waiting.merge(self.state, plan.news)
        return plan.waits and at * self._task.tick - plan.begins < FRESH

    def planned(self, pose: FloatArray, motion: FloatArray, drift: FloatArray) -> Said:
        """What the robot is going to do: pose (3,), mean body velocities (N, 2), drift (2,); returns what it says."""
        state = self.state
        waiting.remember(state, pose, motion, drift)
        said = motion
        if state.whole[WAITS]:
            said = motion.copy()
            waiting.honest(state, said)
        known = np.flatnonzero(state.news[:, 2] >= 0.0)
        news = np.column_stack([known, state.news[known]])
        return Said(float(state.real[RATE]), bool(state.whole[WAITS]), news, said)

    @property
    def need(self) -> float:
        """How long the robot itself needs the formation to wait [s]."""
        return float(self.state.real[NEED])
