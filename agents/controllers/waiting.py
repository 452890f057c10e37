"""How a robot waits for those that cannot keep up, and says so (docs/theory.md, section 15).

It decides while it plans (agents/kernels/best_response.py); here is its memory, and what overrules it.
"""

from agents.controllers.task import Task
from agents.kernels.waiting import CARRIED_TICKS
from agents.kernels.waiting_state import AWAY, INTEGRAL, LAG, NEED, PACE, RATE, SHORT, WAITS, FlatWait, start, view
from formation.arrays import FloatArray


class Waiting:
    """The waiting of one robot, from planning tick to planning tick; keeps its pair's lag and pace."""

    def __init__(self, task: Task) -> None:
        """A robot on time, with this task."""
        self._task, self._row = task, task.robot - 1
        self.memory: FlatWait = start(task.robots, task.horizon)
        """The state, as compiled code takes it; it remembers each plan (agents/kernels/best_response.py)."""
        self._step = task.every * task.tick

    def let_be(self, speeds: FloatArray, k: int) -> None:
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

    @property
    def need(self) -> float:
        """How long the robot itself needs the formation to wait [s]."""
        return float(view(self.memory).real[NEED])
