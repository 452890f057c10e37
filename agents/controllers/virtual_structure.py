"""Controller `virtual_structure`: every robot follows its own slot of a moving rigid body, and uses no message.

After Lewis and Tan (1997) and Ren and Beard (2004), without formation feedback. For a comparison with `nash` that is
about messages only, it is the same receding horizon over the same exact unicycle, limits and reference, solved to
convergence as a team of one robot. Its weights are those that `nash` puts on the centre, which is more than `nash` puts
on a robot's own slot error (docs/theory.md, section 7).
"""

import math

import numpy as np

from agents.controllers.interface import Observation, Solution, options_of
from agents.controllers.nash import weights
from agents.controllers.pair import Pair
from agents.kernels.lq import optimise
from agents.kernels.unicycle import shift
from formation.arrays import FloatArray
from formation.scenario.controllers import VirtualStructureOptions
from formation.scenario.scenario import Scenario

STEPS = 20
TOLERANCE = 1e-6
"""Largest change of an input at which a plan has converged [m/s, rad/s]."""


class VirtualStructure:
    """The controller of one robot."""

    def __init__(self, scenario: Scenario, pair: Pair) -> None:
        own = options_of(scenario, VirtualStructureOptions)
        self._pair = pair
        q, r = weights(scenario)
        self._r = np.array(own.r or r, dtype=float)
        self._weights = np.tile(np.diag(np.array(own.q or q[:3], dtype=float)), (pair.horizon + 1, 1, 1))
        self._last: tuple[int, FloatArray] | None = None

    def plan(self, situation: Observation) -> Solution:
        pair, k = self._pair, situation.k
        ahead = pair.ahead(k)
        slots, targets = np.ascontiguousarray(ahead.slots[:, :1]), np.ascontiguousarray(ahead.inputs[:, :1])
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
