"""What one robot plans with by its best response, in one array (agents/kernels/best_response.py)."""

from typing import NamedTuple

import numpy as np

from agents.kernels.jit import kernel
from agents.kernels.views import shaped
from formation.arrays import FloatArray

WEIGHT, SQUARE, SPACING, SOURCES, TRUST_TIME, STEP, TICK, INTERVAL, STRIDE, BEGUN = range(10)
"""Constants of a planner: S_0, spacing squared [m2] and spacing [m], neighbours whose plans are heard, time constant of
trust in a plan, time from one plan to the next, tick, Delta_T [s]; Delta_T in ticks; 1 once there is a last plan."""
WORK_COLUMNS = 24


class Planner(NamedTuple):
    """What one robot plans with: constants of its cost, its last plan, and room for what a step is made of."""

    constants: FloatArray
    """(10,) see WEIGHT."""
    costs: FloatArray
    """(2,) R where no body is near, see response.Stage."""
    limits: FloatArray
    """(2,) likewise."""
    last: FloatArray
    """(N, 2) inputs of the last plan [m/s, rad/s]."""
    work: FloatArray
    """(N + 1, WORK_COLUMNS) scratch, as all that follows."""
    own: FloatArray
    """(N + 1, 3) own slot."""
    targets: FloatArray
    """(N, 2) its inputs."""
    other: FloatArray
    """(N + 1, 3) slot of a neighbour."""
    nominal: FloatArray
    """(N, 2) inputs to linearise along."""
    direction: FloatArray
    """(2, N + 1, 2), with `error` (2, N + 1) and `drift` (2,) see response.Targets."""
    error: FloatArray
    edge: FloatArray
    """(2,) see response.Stage."""
    prices: FloatArray
    """(2,) R of this step."""
    drift: FloatArray
    start: FloatArray
    """(5,) see response.respond."""


@kernel
def planner_of(flat: FloatArray, steps: int) -> Planner:
    """The planner that lies in one array, as views of it: compiled code takes that array."""
    rows = steps + 1
    targets, nominal, work = 14 + 2 * steps, 14 + 4 * steps, 14 + 6 * steps
    own = work + rows * WORK_COLUMNS
    other = own + 3 * rows
    direction = other + 3 * rows
    error = direction + 4 * rows
    edge = error + 2 * rows
    return Planner(
        shaped(flat, 0, (10,)),
        shaped(flat, 10, (2,)),
        shaped(flat, 12, (2,)),
        shaped(flat, 14, (steps, 2)),
        shaped(flat, work, (rows, WORK_COLUMNS)),
        shaped(flat, own, (rows, 3)),
        shaped(flat, targets, (steps, 2)),
        shaped(flat, other, (rows, 3)),
        shaped(flat, nominal, (steps, 2)),
        shaped(flat, direction, (2, rows, 2)),
        shaped(flat, error, (2, rows)),
        shaped(flat, edge, (2,)),
        shaped(flat, edge + 2, (2,)),
        shaped(flat, edge + 4, (2,)),
        shaped(flat, edge + 6, (5,)),
    )


def planner(constants: tuple[float, ...], costs: tuple[float, float], limits: FloatArray, steps: int) -> FloatArray:
    """A planner that has not planned yet; constants WEIGHT to STRIDE, the rest as in Planner."""
    flat = np.zeros(25 + 6 * steps + (12 + WORK_COLUMNS) * (steps + 1))
    flat[:14] = *constants, 0.0, *costs, *limits
    return flat
