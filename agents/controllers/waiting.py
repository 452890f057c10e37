"""How a robot waits for those that cannot keep up, and says so (docs/theory.md, section 15)."""

import math

import numpy as np

from agents.controllers.interface import NeighborEstimate, Observation
from agents.controllers.task import Task
from agents.kernels.attend import attend
from agents.kernels.waiting import CARRIED_TICKS, FRESH
from agents.kernels.waiting_state import AWAY, INTEGRAL, LAG, NEED, PACE, RATE, SHORT, WAITS, FlatWait, start, view
from formation.arrays import FloatArray

NOTHING_NEW: FloatArray = np.zeros((0, 4))


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
        self._v_max = float(task.limits[0])
        self.memory: FlatWait = start(robots, task.horizon)
        """The state, as compiled code takes it; it remembers each plan (agents/kernels/best_response.py)."""
        self._step = task.every * task.tick

    def update(self, observation: Observation) -> bool:
        """Bring the pair's lag and pace to the observation; whether anybody waits, as far as is known."""
        task, k = self._task, float(observation.k)
        if observation.kept_off is not None:
            self._let_be(observation.kept_off, observation.k)
        news, waits = self._heard(observation.upstream, k)
        more, wait_too = self._heard(observation.downstream, k)
        at = max(k - (task.lag + (1.0 - task.pace) * self._step) / task.tick, 0.0)
        table = task.table(math.floor(at + 1e-9))
        task.lag, task.pace, somebody = attend(
            *self.memory,
            self._row,
            k,
            observation.pose,
            observation.covariance,
            observation.disturbance,
            observation.rejected,
            observation.motor_gap,
            *table,
            at,
            news,
            more,
            waits or wait_too,
            self._spacing,
            self._v_max,
            self._step,
            task.tick,
            task.interval,
        )
        return bool(somebody)

    def _let_be(self, speeds: FloatArray, k: int) -> None:
        """The robot was let drive at speeds (2,) only: that is no reason to wait, nor to begin to soon after."""
        state = view(self.memory)
        state.velocities[:] = speeds
        if not state.whole[WAITS]:
            state.whole[AWAY] = max(int(state.whole[AWAY]), k + CARRIED_TICKS)

    def lose(self, k: int) -> None:
        """The robot is lost at tick k: it declares no need, or stands still and has all others wait for it."""
        state, task = view(self.memory), self._task
        real, whole = state.real, state.whole
        need = max(float(real[NEED]), task.lag) + self._step if task.waits_for_lost else 0.0
        real[NEED], real[RATE] = need, float(task.waits_for_lost)
        real[INTEGRAL] = real[SHORT] = 0.0
        whole[WAITS] = 0
        state.news[self._row] = (need, real[RATE], float(k))
        if task.waits_for_lost:
            real[LAG], real[PACE] = need, 0.0
            task.lag, task.pace = need, 0.0

    def _heard(self, neighbour: NeighborEstimate | None, at: float) -> tuple[FloatArray, bool]:
        """A neighbour's news; whether its newest plan says that it waits."""
        if neighbour is None or neighbour.plan is None:
            return NOTHING_NEW, False
        plan = neighbour.plan
        return plan.news, plan.waits and at * self._task.tick - plan.begins < FRESH

    @property
    def need(self) -> float:
        """How long the robot itself needs the formation to wait [s]."""
        return float(view(self.memory).real[NEED])
