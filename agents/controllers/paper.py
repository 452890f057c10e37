"""Controller `paper`: section 3.2 of the paper as printed; `controller.errata` mends it item by item.

Errata 1 to 5 and 14 are of the algorithm (14 mends eqs. (10) and (11) another way than 5). 6 and 7 are of two tests'
data, which here follow from the offsets; `controller.misprints` brings them back. 11 and 13 are the leader-follower's.
experiments/errata/errata.py has the whole list.
"""

import math

import numpy as np

from agents.controllers.interface import Observation, Solution, options_of
from agents.controllers.pair import Pair
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

    def __init__(self, scenario: Scenario, robot: int, pair: Pair) -> None:
        own = options_of(scenario, PaperOptions)
        self._pair = pair
        self._q = np.array(own.q or (Q_TWO if scenario.size == 2 else Q_MORE), dtype=float)
        self._r = np.array(own.r or R, dtype=float)
        self._mended = np.zeros(SWITCHES, dtype=bool)
        self._mended[[SWITCH[number] for number in own.errata]] = True
        self._infeasible = 6 in own.misprints and scenario.formation.shape == "triangle"
        self._mirrored = 7 in own.misprints and (scenario.size, robot) == (2, 2)
        self._last: FloatArray = np.zeros((pair.horizon, 2))  # step 2: the first plan is zero

    def plan(self, situation: Observation) -> Solution:
        pair = self._pair
        block, row = pair.block(situation.k)
        ahead = slice(row, row + pair.horizon * pair.stride + 1, pair.stride)
        ref = block.centre[ahead]
        distance, angle, centre = self._pattern(situation.k)
        psi_r = -ref[:, 2] if self._mirrored else ref[:, 2] + angle
        out = np.empty((pair.horizon, 2))
        received = situation.upstream.inputs if situation.upstream.plan else np.zeros((pair.horizon, 2))
        plan(
            situation.pose,
            self._last,
            situation.upstream.pose,
            received,
            ref,
            psi_r,
            distance,
            centre,
            pair.interval,
            self._q,
            self._r,
            pair.limits,
            self._mended,
            out,
        )
        converged = bool(np.isfinite(out).all())
        self._last = out if converged else np.zeros_like(out)
        return Solution(self._last, converged)

    def _pattern(self, k: int) -> tuple[float, float, FloatArray]:
        """l_r [m], psi_offset [rad] and p_v^O (2,) [m] of the pair as they are at tick k."""
        own, other = self._pair.offsets(k)
        wanted = between(own[None], other[None])
        distance = float(wanted.distance[0])
        centre = np.full(2, math.sqrt(3.0) / 6.0 * distance) if self._infeasible else np.array(wanted.centre[0])
        return distance, float(wanted.angle[0]), centre
