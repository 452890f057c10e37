"""Waiting by PI with an announced rate (docs/theory.md, section 15): who cannot keep up holds the clock back.

A robot's reference is the scenario's at t - lag. Who is behind its slot and does not move as it planned raises its own
need n at a rate that a PI law finds; it announces n and the rate r, and everybody's lag follows the largest need heard,
carried on by its rate. Only a robot's own need raises its n, so that no rumour runs round the ring.
"""

import math
from typing import NamedTuple

import numpy as np

from agents.kernels.drifting import age_drifting, between
from agents.kernels.jit import kernel
from agents.kernels.waiting_state import (
    AWAY,
    DOUBTED,
    INTEGRAL,
    LAG,
    NEED,
    PACE,
    PAST,
    PEAK,
    PLANNED,
    RATE,
    SHORT,
    SINCE,
    SPEED,
    UNABLE,
    WAITS,
    Wait,
)
from formation.arrays import FloatArray

CHARGE, LEAK = 0.1, 1.5
"""The integral: time constant of p [s], and what it loses [1/s]."""
DONE = 0.005
"""Below this the integral lets waiting end."""
MEMORY = 0.25
"""Time constant of `short` [s]."""
LEAST_FREE, LEAST_WIDTH = 0.025, 0.03
"""Spacings."""
TURN_FREE, TURN_CALM, TURN_MEMORY = 0.03, 0.2, 0.5
SETTLE = 0.5
"""Time in which a need is worked off [s]."""
PULL = 20.0
"""How fast a lag follows the need [1/s]."""
SOON = 0.025
"""r falls by (SOON / age^2) per second: nobody runs ahead of who has not heard yet."""
LEAST = 1e-4
"""A need below this is none [s]."""
FRESH, KNOWN, CAP = 2.0, 5.0, 3.0
"""News younger than FRESH can say that somebody waits, than KNOWN moves the lag; carried on by CAP at most [s]."""
ABLE_GAP, ABLE_SHARE, ABLE_TICKS = 0.010, 1.2, 50
MARGIN = 0.95
CUT = 0.003
"""A waiting robot promises this much more speed than it reached lately [m/s]."""
REACHED = 0.1
"""Time constant of that mean [s]."""
CARRIED, CARRIED_TIME, CARRIED_TICKS, EARLY = 0.003, 0.16, 60, 20
"""A robot that got backwards or sideways by more than 3 mm and 4 standard deviations of its position within 0.16 s is
carried away, not unable to move: for 0.6 s what it did not make is no reason to wait. Only before it waits, and 0.2 s
into it: later a stuck robot's estimate runs ahead and is pulled back."""
DOUBT, DOUBTS, DOUBT_AGAIN = 3, 30, 100
"""Where so many localisations in a row were rejected, where the robot is shows 0.3 s later: until then it does not
begin to wait; at most once a second."""


class Self(NamedTuple):
    """What a robot knows of itself when it decides whether to wait."""

    robot: int
    stamp: float
    """t + d, in ticks."""
    pose: FloatArray
    """(3,) at the stamp."""
    sigma: float
    """Standard deviation of its position along its heading [m]."""
    disturbance: float
    """d_v [m/s]."""
    rejected: int
    """Localisations rejected in a row."""
    gap: float
    """Speed that was commanded less that of the wheels, in the last tick [m/s]."""


@kernel
def merge(w: Wait, news: FloatArray) -> None:
    """Take news from a plan, rows (robot from 0, n [s], r, stamp [ticks]); the newest stamp wins."""
    for i in range(len(news)):
        q = int(news[i, 0])
        if 0 <= q < len(w.news) and news[i, 3] > w.news[q, 2]:
            for c in range(3):
                w.news[q, c] = news[i, 1 + c]


@kernel
def ages(w: Wait, robot: int, stamp: float, dt: float) -> float:
    """Age of the oldest news of any other robot [s], at least 0.02; who is silent for longer than KNOWN is gone."""
    oldest = 0.02
    for q in range(len(w.news)):
        old = (stamp - max(w.news[q, 2], 0.0)) * dt
        if q != robot and old <= KNOWN:
            oldest = max(oldest, old)
    return oldest


@kernel
def somebody(w: Wait, robot: int, stamp: float, heard_waits: bool, dt: float) -> bool:
    """Whether anybody waits, as far as is known."""
    if heard_waits or w.whole[WAITS] == 1 or w.real[NEED] > 0.001:
        return True
    for q in range(len(w.news)):
        if q != robot and w.news[q, 2] >= 0.0 and w.news[q, 0] > 0.001 and (stamp - w.news[q, 2]) * dt < FRESH:
            return True
    return False


@kernel
def _carried(w: Wait, pose: FloatArray, forward: float, h: float) -> float:
    """How far the robot got backwards or sideways in the last CARRIED_TIME [m]; wheels alone cannot do that."""
    back = min(max(round(CARRIED_TIME / h), 1), PAST) - 1
    then = w.past[back]
    found = 0.0
    if not math.isnan(then[0]):
        middle = 0.5 * (then[2] + pose[2])
        c, s = math.cos(middle), math.sin(middle)
        dx, dy = pose[0] - then[0], pose[1] - then[1]
        found = max(-forward * (c * dx + s * dy), abs(c * dy - s * dx))
    for a in range(PAST - 1, 0, -1):
        for c in range(3):
            w.past[a, c] = w.past[a - 1, c]
    for c in range(3):
        w.past[0, c] = pose[c]
    return found


@kernel
def _follow(w: Wait, robot: int, stamp: float, h: float, dt: float) -> None:
    """Lag and pace follow the largest need that is known."""
    real = w.real
    best, rate, who = real[NEED], real[RATE], robot
    for q in range(len(w.news)):
        old = (stamp - w.news[q, 2]) * dt
        if q != robot and w.news[q, 2] >= 0.0 and old <= KNOWN:
            need = w.news[q, 0] + w.news[q, 1] * min(max(old, 0.0), CAP)
            if need > best:
                best, rate, who = need, w.news[q, 1], q
    lag = real[LAG]
    if who == robot:
        lag = real[NEED]
    else:
        lag += rate * h + min(PULL * h, 1.0) * (best - lag - rate * h)
    lag = between(lag, real[LAG] - 2.0 * h, real[LAG] + 2.0 * h)
    real[LAG] = between(lag, 0.0, stamp * dt)
    real[PACE] = 1.0 - between(rate, -1.0, 1.0)


@kernel
def decide(  # noqa: PLR0915  one law, in the order of its equations
    w: Wait,
    me: Self,
    slot: FloatArray,
    rates: FloatArray,
    spacing: float,
    v_max: float,
    h: float,
    dt: float,
    interval: float,
) -> None:
    """Bring need, rate, lag and pace to this planning tick.

    Args:
        w: changed.
        me: see there.
        slot: (3,) the own slot at the stamp less the lag, which has grown by (1 - pace) h since the last plan.
        rates: (2,) its v and omega at pace 1 [m/s, rad/s].
        spacing: [m].
        v_max: limit of |v| [m/s].
        h: time from one plan to the next [s].
        dt: tick [s].
        interval: Delta_T [s].
    """
    real, whole, pose = w.real, w.whole, me.pose
    v_r, omega_r = rates[0], rates[1]
    forward = 1.0 if v_r >= 0.0 else -1.0
    c, s = math.cos(slot[2]), math.sin(slot[2])
    behind = forward * (c * (slot[0] - pose[0]) + s * (slot[1] - pose[1])) / spacing
    c, s = math.cos(pose[2]), math.sin(pose[2])
    real[SHORT] *= math.exp(-h / MEMORY)
    now = int(me.stamp)
    if whole[PLANNED] == 1:
        expected = np.empty(3)
        age_drifting(w.pose, w.velocities, w.drift, h, interval, expected)
        real[SHORT] += forward * (c * (expected[0] - pose[0]) + s * (expected[1] - pose[1])) / spacing
        moved = (c * (pose[0] - w.pose[0]) + s * (pose[1] - w.pose[1])) / h
        real[SPEED] += (1.0 - math.exp(-h / REACHED)) * (moved - real[SPEED])
    carried = _carried(w, pose, forward, h)
    if (whole[WAITS] == 0 or now < whole[SINCE] + EARLY) and carried > CARRIED + 4.0 * me.sigma:
        whole[AWAY] = now + CARRIED_TICKS
    if now < whole[AWAY]:
        real[SHORT] = min(real[SHORT], 0.0)
    real[PEAK] = max(abs(omega_r), real[PEAK] * math.exp(-h / TURN_MEMORY))

    if abs(me.gap) >= ABLE_GAP or abs(me.disturbance) >= ABLE_SHARE * abs(v_r):
        whole[UNABLE] = now + ABLE_TICKS
    oldest = ages(w, me.robot, me.stamp, dt)
    free = max(LEAST_FREE, min(5.0 * me.sigma / spacing, 0.1))
    if now >= whole[UNABLE]:
        free = max(free, 0.1 * min(oldest, 0.6))
    width = max(LEAST_WIDTH, free)
    free += TURN_FREE * max(real[PEAK] - TURN_CALM, 0.0)

    if me.rejected >= DOUBT and now > whole[DOUBTED] + DOUBT_AGAIN:
        whole[DOUBTED] = now
    if whole[WAITS] == 0 and now < whole[DOUBTED] + DOUBTS:
        p = 0.0
    elif whole[WAITS] == 0:
        p = between((min(behind, real[SHORT]) - free) / width, 0.0, 1.0)
        if p > 0.0:
            whole[WAITS], whole[SINCE] = 1, now
            real[NEED] = max(real[NEED], real[LAG])
    else:
        push = behind if behind < 0.0 else min(behind, max(real[SHORT], 0.0))
        p = between(push / width, -1.0, 1.0)
    real[INTEGRAL] = between(real[INTEGRAL] + h * (p / CHARGE - LEAK), 0.0, 1.0)
    if whole[WAITS] == 1 and real[INTEGRAL] < DONE and p <= 0.0:
        whole[WAITS] = 0
    if whole[WAITS] == 1:
        real[NEED] += h * between(p + real[INTEGRAL], 0.0, 1.0)
        real[RATE] = real[INTEGRAL]
    else:
        haste = max(MARGIN * v_max / max(abs(v_r), 1e-9) - 1.0, 0.0)
        target = -min(1.0, haste, real[NEED] / SETTLE)
        real[RATE] = max(target, real[RATE] - SOON / (oldest * oldest) * h)
        real[NEED] = max(real[NEED] + real[RATE] * h, 0.0)
        if real[NEED] <= LEAST:
            real[NEED] = real[RATE] = 0.0
    w.news[me.robot, 0], w.news[me.robot, 1], w.news[me.robot, 2] = real[NEED], real[RATE], me.stamp
    _follow(w, me.robot, me.stamp, h, dt)


@kernel
def remember(w: Wait, pose: FloatArray, velocities: FloatArray, drift: FloatArray) -> None:
    """What the robot is going to do: pose (3,) at the stamp, velocities (N, 2), drift (2,)."""
    for c in range(3):
        w.pose[c] = pose[c]
    for c in range(2):
        w.drift[c] = drift[c]
        for j in range(len(velocities)):
            w.velocities[j, c] = velocities[j, c]
    w.whole[PLANNED] = 1


@kernel
def honest(w: Wait, velocities: FloatArray) -> None:
    """A waiting robot's announced velocities (N, 2) are no faster than it got lately."""
    if w.whole[WAITS] == 1:
        for j in range(len(velocities)):
            velocities[j, 0] = min(velocities[j, 0], w.real[SPEED] + CUT)


@kernel
def known(w: Wait, out: FloatArray) -> int:
    """What is known of every robot's waiting, for a plan: rows (robot from 0, n [s], r, stamp) of out (n, 4).

    Returns how many rows are used.
    """
    count = 0
    for q in range(len(w.news)):
        if w.news[q, 2] >= 0.0:
            out[count, 0] = q
            for c in range(3):
                out[count, 1 + c] = w.news[q, c]
            count += 1
    return count
