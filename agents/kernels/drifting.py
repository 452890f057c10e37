"""One unicycle's motion with a drift: what the estimator and the best response share beside kernels/unicycle.py."""

import math

import numpy as np

from agents.kernels.jit import (
    MATRIX,
    MATRIX_OUT,
    NOTHING,
    REAL,
    STRIDED,
    TABLE,
    VECTOR,
    VECTOR_OUT,
    WHOLE,
    entry_for,
    kernel,
    kernel_for,
)
from agents.kernels.unicycle import sample_inputs, shift, step
from formation.arrays import FloatArray

SLOW = 0.01
"""Speed of a slot below which its heading is not turned against a drift [m/s]."""


@kernel
def wrap_small(angle: float) -> float:
    """The same angle in [-pi, pi] [rad]; cheap where it is small already."""
    if -3.14159 < angle < 3.14159:
        return angle
    return math.atan2(math.sin(angle), math.cos(angle))


@kernel
def between(value: float, low: float, high: float) -> float:
    """Value held within low .. high."""
    return min(max(value, low), high)


@kernel
def believed(lateral: float, noise: float) -> float:
    """What is believed of an estimated lateral drift: all far above the noise, half at it, little below [m/s]."""
    square = lateral * lateral
    return lateral * (square / (square + noise * noise)) if square > 0.0 else 0.0


@kernel
def turned(slots: FloatArray, targets: FloatArray, lateral: float) -> None:
    """Turn the headings of slots (N + 1, 3) against a lateral drift [m/s], so that the robot moves along them."""
    for j in range(len(slots)):
        speed = targets[min(j, len(targets) - 1), 0]
        if abs(speed) > SLOW:
            slots[j, 2] -= math.atan(between(lateral / speed, -0.5, 0.5))


@kernel
def age_drifting(
    pose: FloatArray, inputs: FloatArray, drift: FloatArray, elapsed: float, interval: float, out: FloatArray
) -> None:
    """The pose (3,) that a plan predicts `elapsed` after it begins, at most to its end; into out (3,).

    Args:
        pose: (3,) where the plan begins [m, m, rad].
        inputs: (N, 2) mean body velocities per interval [m/s, rad/s].
        drift: (2,) in the world frame [m/s].
        elapsed: [s]; if it is negative, the first input held before the plan began.
        interval: Delta_T [s].
        out: (3,).
    """
    x, y, theta = pose[0], pose[1], pose[2]
    left = elapsed
    if elapsed < 0.0:  # the sender looks further ahead than we do
        x, y, theta = step(x, y, theta, inputs[0, 0], inputs[0, 1], elapsed)
    for j in range(len(inputs)):
        if left <= 1e-12:
            break
        x, y, theta = step(x, y, theta, inputs[j, 0], inputs[j, 1], min(left, interval))
        left -= interval
    out[0], out[1], out[2] = x + drift[0] * elapsed, y + drift[1] * elapsed, theta


@kernel_for(NOTHING, VECTOR, MATRIX, VECTOR, REAL, REAL, STRIDED, VECTOR_OUT, MATRIX_OUT)
def carry(
    pose: FloatArray,
    inputs: FloatArray,
    drift: FloatArray,
    elapsed: float,
    interval: float,
    tail: FloatArray,
    out: FloatArray,
    out_inputs: FloatArray,
) -> None:
    """A plan carried forward: pose, out (3,), and inputs, out_inputs (N, 2), `elapsed` after it begins.

    Args:
        pose, inputs, drift, elapsed, interval: see `age_drifting`.
        tail: (N, 2) inputs for when the plan has ended.
        out, out_inputs: results.
    """
    age_drifting(pose, inputs, drift, elapsed, interval, out)
    shift(inputs, max(elapsed, 0.0), interval, tail, out_inputs)


@entry_for(NOTHING, *(VECTOR, MATRIX, VECTOR, REAL, REAL), *(TABLE, REAL, REAL, REAL, WHOLE), *(VECTOR_OUT, MATRIX_OUT))
def carry_along(
    pose: FloatArray,
    inputs: FloatArray,
    drift: FloatArray,
    elapsed: float,
    interval: float,
    table: FloatArray,
    row: float,
    stride: float,
    pace: float,
    column: int,
    out: FloatArray,
    out_inputs: FloatArray,
) -> None:
    """`carry`, with the tail from the reference.

    Args:
        pose, inputs, drift, elapsed, interval: see `age_drifting`.
        table, row, stride, pace: inputs (T, n, 2) of the reference, see unicycle.sample.
        column: of the neighbour.
        out, out_inputs: results.
    """
    tail = np.empty((len(out_inputs), 2))
    sample_inputs(table, row, stride, pace, column, tail)
    carry(pose, inputs, drift, elapsed, interval, tail, out, out_inputs)


@kernel
def slot_at(table: FloatArray, row: float, out: FloatArray) -> None:
    """Slot pose, out (3,), of one robot's table (T, 3) at a row that may lie between two ticks."""
    k = min(max(int(row + 1e-9), 0), len(table) - 2)
    part = max(row - k, 0.0)
    for c in range(2):
        out[c] = table[k, c] + part * (table[k + 1, c] - table[k, c])
    out[2] = table[k, 2] + part * wrap_small(table[k + 1, 2] - table[k, 2])
