"""Waiting as Python calls it: one call a planning tick (docs/theory.md, section 15)."""

import math

import numpy as np

from agents.kernels.jit import (
    FLAG,
    MATRIX,
    REAL,
    TABLE,
    VECTOR,
    VECTOR_OUT,
    WHOLE,
    WHOLE_VECTOR_OUT,
    kernel,
    kernel_for,
    several,
)
from agents.kernels.waiting import Self, decide, merge, somebody
from agents.kernels.waiting_state import LAG, PACE, wait_of
from formation.arrays import FloatArray, IntArray


@kernel
def _place(slots: FloatArray, inputs: FloatArray, first: int, at: float, slot: FloatArray, rates: FloatArray) -> None:
    """The own slot (3,) at tick `at`, which may lie between two, and its inputs (2,) at the one before."""
    row = math.floor(at + 1e-9) - first
    part = max(at - row - first, 0.0)
    gap = slots[row + 1, 0, 2] - slots[row, 0, 2]
    turn = math.atan2(math.sin(gap), math.cos(gap))
    for c in range(2):
        slot[c] = slots[row, 0, c] + part * (slots[row + 1, 0, c] - slots[row, 0, c])
        rates[c] = inputs[row, 0, c]
    slot[2] = slots[row, 0, 2] + part * turn


@kernel_for(
    several(REAL, REAL, FLAG),
    *(VECTOR_OUT, WHOLE_VECTOR_OUT, WHOLE, REAL, VECTOR, MATRIX, VECTOR, WHOLE, REAL),
    *(TABLE, TABLE, WHOLE, REAL, MATRIX, MATRIX, FLAG),
    *(REAL, REAL, REAL, REAL, REAL),
)
def attend(
    real: FloatArray,
    whole: IntArray,
    robot: int,
    stamp: float,
    pose: FloatArray,
    covariance: FloatArray,
    disturbance: FloatArray,
    rejected: int,
    gap: float,
    slots: FloatArray,
    inputs: FloatArray,
    first: int,
    at: float,
    news: FloatArray,
    more_news: FloatArray,
    heard_waits: bool,
    spacing: float,
    v_max: float,
    h: float,
    dt: float,
    interval: float,
) -> tuple[float, float, bool]:
    """Take the neighbours' news and decide, at a planning tick.

    Args:
        real, whole: the waiting, see FlatWait; changed.
        robot, stamp, pose, rejected, gap: see Self.
        covariance: (3, 3) of the pose.
        disturbance: (3,) d_v, d_l, d_w of the own robot [m/s, m/s, rad/s].
        slots, inputs, first: the reference, column 0 the own slot, see window.filter.Table.
        at: tick of the own slot by the reference time.
        news, more_news: of the neighbours' plans, see `merge`.
        heard_waits: whether a fresh plan says that its robot waits.
        spacing, v_max, h, dt, interval: see `decide`.

    Returns:
        Lag [s], pace, and whether anybody waits, as far as is known.
    """
    w = wait_of(real, whole)
    merge(w, news)
    merge(w, more_news)
    slot, rates = np.empty(3), np.empty(2)
    _place(slots, inputs, first, at, slot, rates)
    c, s = math.cos(pose[2]), math.sin(pose[2])
    p = covariance
    variance = c * c * p[0, 0] + 2.0 * c * s * p[0, 1] + s * s * p[1, 1]
    me = Self(robot, stamp, pose, math.sqrt(max(variance, 0.0)), disturbance[0], rejected, gap)
    decide(w, me, slot, rates, spacing, v_max, h, dt, interval)
    return w.real[LAG], w.real[PACE], somebody(w, robot, stamp, heard_waits, dt)
