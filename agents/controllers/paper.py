"""Controller `paper`: section 3.2 of the paper as printed; `controller.errata` mends it item by item.

Errata 1 to 5 and 14 are of the algorithm (14 mends eqs. (10) and (11) another way than 5). 6 and 7 are of two tests'
data, which here follow from the offsets; `controller.misprints` brings them back. 11 and 13 are the leader-follower's.
experiments/errata/errata.py has the whole list.
"""

import math

import numpy as np

from agents.controllers.interface import Observation, Solution, options_of
from agents.controllers.task import Task
from agents.kernels.paper_errors import BEST_RESPONSE, SWITCHES
from agents.kernels.paper_game import plan
from formation.arrays import FloatArray
from formation.pattern import between
from formation.scenario.controllers import PaperOptions
from formation.scenario.scenario import Scenario

Q_TWO = (0.1, 0.1, 0.1, 0.5, 0.001)
Q_MORE = (0.1, 0.1, 0.1, 0.2, 0.01)
R = (0.1, 0.1)
SWITCH = {1: 1, 2: 2, 3: 3, 4: 4, 5: 5, 14: BEST_RESPONSE}
"""Switch of the kernels by number of erratum."""


class Paper:
    """The controller of one robot."""

    def __init__(self, scenario: Scenario, robot: int, task: Task) -> None:
        own = options_of(scenario, PaperOptions)
        self._task = task
        self._q = np.array(own.q or (Q_TWO if scenario.size == 2 else Q_MORE), dtype=float)
        self._r = np.array(own.r or R, dtype=float)
        self._mended = np.zeros(SWITCHES, dtype=bool)
        self._mended[[SWITCH[number] for number in own.errata]] = True
        self._infeasible = 6 in own.misprints and scenario.formation.shape == "triangle"
        self._mirrored = 7 in own.misprints and (scenario.size, robot) == (2, 2)
        self._last: FloatArray = np.zeros((task.horizon, 2))  # step 2: the first plan is zero

    def plan(self, observation: Observation) -> Solution:
        task = self._task
        block, row = task.block(observation.k)
        ahead = slice(row, row + task.horizon * task.stride + 1, task.stride)
        ref = block.centre[ahead]
        distance, angle, centre = self._pattern(observation.k)
        psi_r = -ref[:, 2] if self._mirrored else ref[:, 2] + angle
        out = np.empty((task.horizon, 2))
        received = observation.upstream.inputs if observation.upstream.plan else np.zeros((task.horizon, 2))
        plan(
            observation.pose,
            self._last,
            observation.upstream.pose,
            received,
            ref,
            psi_r,
            distance,
            centre,
            task.interval,
            self._q,
            self._r,
            task.limits,
            self._mended,
            out,
        )
        converged = bool(np.isfinite(out).all())
        self._last = out if converged else np.zeros_like(out)
        return Solution(self._last, converged)

    def _pattern(self, k: int) -> tuple[float, float, FloatArray]:
        """l_r [m], psi_offset [rad] and p_v^O (2,) [m] of the pair as they are at tick k."""
        own, other = self._task.offsets(k)
        wanted = between(own[None], other[None])
        distance = float(wanted.distance[0])
        centre = np.full(2, math.sqrt(3.0) / 6.0 * distance) if self._infeasible else np.array(wanted.centre[0])
        return distance, float(wanted.angle[0]), centre


def make(scenario: Scenario, robot: int, task: Task) -> Paper:
    """The controller of one robot."""
    return Paper(scenario, robot, task)
