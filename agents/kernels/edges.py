"""A neighbour's error along the edge to it, over a horizon (docs/theory.md, section 14)."""

import math

from agents.kernels.jit import MATRIX, MATRIX_OUT, NOTHING, REAL, STRIDED, VECTOR, VECTOR_OUT, kernel_for
from agents.kernels.unicycle import step
from formation.arrays import FloatArray


@kernel_for(NOTHING, VECTOR, MATRIX, VECTOR, STRIDED, STRIDED, REAL, MATRIX_OUT, VECTOR_OUT)
def errors_along(
    pose: FloatArray,
    inputs: FloatArray,
    drift: FloatArray,
    slots: FloatArray,
    own: FloatArray,
    interval: float,
    direction: FloatArray,
    error: FloatArray,
) -> None:
    """Where the edge points, and how far the neighbour is from its slot along it.

    Args:
        pose: (3,) of the neighbour where the horizon begins [m, m, rad].
        inputs: (N, 2) its mean body velocities [m/s, rad/s].
        drift: (2,) its drift in the world frame [m/s].
        slots: (N + 1, 3) its slot.
        own: (N + 1, 3) the own slot.
        interval: Delta_T [s].
        direction: (N + 1, 2), result: unit vectors from the own slot to the neighbour's.
        error: (N + 1,), result: slot less pose, along that direction [m].
    """
    x, y, theta = pose[0], pose[1], pose[2]
    for j in range(len(slots)):
        dx, dy = slots[j, 0] - own[j, 0], slots[j, 1] - own[j, 1]
        scale = 1.0 / max(math.hypot(dx, dy), 1e-9)
        direction[j, 0], direction[j, 1] = dx * scale, dy * scale
        error[j] = direction[j, 0] * (slots[j, 0] - x) + direction[j, 1] * (slots[j, 1] - y)
        if j < len(inputs):
            x, y, theta = step(x, y, theta, inputs[j, 0], inputs[j, 1], interval)
            x, y = x + drift[0] * interval, y + drift[1] * interval
