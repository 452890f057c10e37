"""What a neighbour's plan counts for at a planning tick: how far it is trusted, and what it says of waiting.

docs/theory.md, sections 14 and 15.
"""

import math

import numpy as np

from agents.kernels.jit import kernel
from agents.kernels.waiting import Self, decide, merge, somebody
from agents.kernels.waiting_state import Wait
from formation.arrays import FloatArray

ALARM_TIME, ALARM_MEMORY, ALARM_LEAST = 0.1, 0.5, 0.1
"""While the own robot is newly disturbed, trust fades with this time constant; for how long that holds [s]."""
SIGHT_TIME, SIGHT_LEAST = 0.6, 0.3
"""Trust in a neighbour that is seen: how fast it fades [s], and what is left of it."""
WAIT_TIME = 0.05
"""While anybody waits, trust fades with this time constant: a stuck robot's plan is wrong [s]."""


@kernel
def trust_in(age: float, seen: bool, trust_time: float, alarm_age: float, waiting: bool) -> float:
    """f_q of one neighbour.

    Args:
        age: of its plan [s]; inf without one.
        seen: whether its pose comes from relative sensing.
        trust_time: time constant with which trust in a plan fades with its age [s].
        alarm_age: since the last detection of a disturbance of the own robot [s].
        waiting: whether anybody waits.
    """
    if not (seen or math.isfinite(age)):
        return 0.0
    if seen:
        f = max(SIGHT_LEAST, math.exp(-age / SIGHT_TIME))
    else:
        f = math.exp(-age / trust_time)
        if math.exp(-alarm_age / ALARM_MEMORY) >= ALARM_LEAST:
            f *= math.exp(-age / ALARM_TIME)
    return f * math.exp(-age / WAIT_TIME) if waiting else f


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


@kernel
def attend(
    w: Wait,
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
) -> bool:
    """Take the neighbours' news and decide, at a planning tick.

    Args:
        w: the waiting; changed, its lag [s] and pace too.
        robot, stamp, pose, rejected, gap: see Self.
        covariance: (3, 3) of the pose.
        disturbance: (3,) d_v, d_l, d_w of the own robot [m/s, m/s, rad/s].
        slots, inputs, first: the reference, column 0 the own slot, see window.filter.Table.
        at: tick of the own slot by the reference time.
        news, more_news: of the neighbours' plans, see `merge`.
        heard_waits: whether a fresh plan says that its robot waits.
        spacing, v_max, h, dt, interval: see `decide`.

    Returns:
        Whether anybody waits, as far as is known.
    """
    merge(w, news)
    merge(w, more_news)
    slot, rates = np.empty(3), np.empty(2)
    _place(slots, inputs, first, at, slot, rates)
    c, s = math.cos(pose[2]), math.sin(pose[2])
    p = covariance
    variance = c * c * p[0, 0] + 2.0 * c * s * p[0, 1] + s * s * p[1, 1]
    me = Self(robot, stamp, pose, math.sqrt(max(variance, 0.0)), disturbance[0], rejected, gap)
    decide(w, me, slot, rates, spacing, v_max, h, dt, interval)
    return bool(somebody(w, robot, stamp, heard_waits, dt))
