"""Controller `virtual_structure`: every robot follows its own slot of a moving rigid body, and listens to nobody.

After Lewis and Tan (1997) and Ren and Beard (2004), without formation feedback. For a comparison with `nash` that is
about messages only, it is the same receding horizon over the same exact unicycle, limits and reference, with the
weights that `nash` puts on the centre; solved to convergence (agents/team_kernel.py for a team of one).
"""

import math

import numpy as np

from agents.kernels import shift
from agents.situation import Pair, Situation, Solution
from agents.team_kernel import optimise
from formation.arrays import FloatArray
from formation.scenario import Scenario

Q = (1.0, 1.0, 0.01)
"""x, y, heading: what `nash` weighs of the centre."""
R = (0.01, 0.01)
STEPS = 20
TOLERANCE = 1e-6
"""Largest change of an input at which a plan has converged [m/s, rad/s]."""


class VirtualStructure:
    """The controller of one robot."""

    def __init__(self, scenario: Scenario, pair: Pair) -> None:
        own = scenario.controller
        self._pair = pair
        self._r = np.array(own.r or R, dtype=float)
        self._weights = np.tile(np.diag(np.array(own.q or Q, dtype=float)), (pair.horizon + 1, 1, 1))
        self._last: tuple[int, FloatArray] | None = None

    def plan(self, situation: Situation) -> Solution:
        pair, k = self._pair, situation.k
        block, row = pair.block(k)
        ahead = pair.stride * pair.horizon
        slots = np.ascontiguousarray(block.slots[row : row + ahead + 1 : pair.stride, :1])
        targets = np.ascontiguousarray(block.inputs[row : row + ahead : pair.stride, :1])
        nominal = targets[:, 0].copy()
        if self._last is not None:
            made, inputs = self._last
            shift(inputs, (k - made) * pair.tick, pair.interval, targets[:, 0], nominal)
        out = np.empty_like(nominal)
        task = (slots, targets, self._weights, self._r, pair.interval, pair.limits)
        converged = math.isfinite(optimise(situation.pose, nominal, *task, STEPS, TOLERANCE, out))
        if not converged:
            out = np.clip(np.nan_to_num(nominal), -pair.limits, pair.limits)
        self._last = (k, out)
        return Solution(out, converged)
