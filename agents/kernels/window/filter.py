"""The estimator of one robot (docs/theory.md, section 12): a window of W robots, one joint filter, raw measurements.

Every measurement enters at its own stamp. The base stands where everything is known; a copy runs from there to the own
newest stamp and is the estimate.
"""

import math
from typing import NamedTuple

import numpy as np

from agents.kernels.drifting import slot_at, wrap_small
from agents.kernels.jit import (
    kernel,
)
from agents.kernels.unicycle import step
from agents.kernels.window.state import DL, DV, DW, LENGTH, SIGHT, Core, Tuning, Window, base, copy, estimate
from agents.kernels.window.steps import localise, predict, relate, scalar
from formation.arrays import FloatArray

BACK = 120
"""The base stays behind for a silent neighbour by at most so many ticks (1.2 s)."""
ROOM = 64
"""Ticks before the end of the kept history at which the base moves on without measurements."""
OVERDUE = 4
"""Ticks after which a neighbour's measurement is missing."""
CALM = 0.0015
"""Standard deviation of d_v and d_l [m/s] below which a silent neighbour is believed to be in its slot."""
IN_SLOT, IN_SLOT_HEADING = 0.003, 0.05
"""Standard deviations of that belief [m, rad]."""
GUESSED = (0.01, 0.005, 0.1)
"""Noise of odometry that is guessed from a plan or a slot, beside that of odometry [m/s, m/s, rad/s]."""
UNHEARD = (0.025, 0.0125, 0.1)
"""The same of a neighbour that is seen but never heard."""
COLUMNS = 9
"""Of a row of measurements in a plan: hop, stamp [ticks], 1 if localised, x, y, theta, 1 if related, x, y."""
KEPT = 4
"""Measurement stamps of a robot that a plan carries."""


class Table(NamedTuple):
    """Part of the reference by tick; column h is the robot of block h, then others that the agent may need."""

    slots: FloatArray
    """(T, c, 3) [m, m, rad]."""
    inputs: FloatArray
    """(T, c, 2) [m/s, rad/s]."""
    first: int
    """Tick of row 0."""


class Heard(NamedTuple):
    """What the newest plan of the upstream neighbour says of how it moves."""

    here: bool
    """Whether there is one that has not ended."""
    begins: float
    """Where its horizon begins [ticks]."""
    stride: float
    """Ticks of one of its intervals."""
    inputs: FloatArray
    """(N, 2) mean body velocities [m/s, rad/s]."""
    twist: FloatArray
    """(2,) mean body velocity from its sending to its beginning [m/s, rad/s]."""
    disturbance: FloatArray
    """(2,) d_v, d_w that the sender estimates of itself [m/s, rad/s]."""


@kernel
def hear(w: Window, odometry: FloatArray, rows: FloatArray, dt: float) -> None:
    """Take odometry and measurements from the upstream neighbour's plan; what was there before changes nothing.

    Args:
        w: changed.
        odometry: (H, 4) integrals of v and omega [m, rad], the tick before which they end, and that at which they
            began: of the sender and of those upstream that it passes on.
        rows: (m, COLUMNS) measurements.
        dt: [s].
    """
    for h in range(1, min(len(w.until), len(odometry) + 1)):
        until, known = w.until[h], int(odometry[h - 1, 2])
        anew = odometry[h - 1, 3] != w.sums[h, 2]  # the robot's agent has begun anew, or ours has
        if known > until and not anew:
            v = (odometry[h - 1, 0] - w.sums[h, 0]) / ((known - until) * dt)
            omega = (odometry[h - 1, 1] - w.sums[h, 1]) / ((known - until) * dt)
            for t in range(max(until, known - LENGTH), known):
                w.odometry[h, t % LENGTH, 0], w.odometry[h, t % LENGTH, 1] = v, omega
        if known > until:
            w.sums[h, 0], w.sums[h, 1], w.sums[h, 2] = odometry[h - 1, 0], odometry[h - 1, 1], odometry[h - 1, 3]
            w.until[h] = known
    for i in range(len(rows)):
        h, t = int(rows[i, 0]) + 1, int(rows[i, 1])
        if h >= len(w.until) or t < w.until[h] - LENGTH:
            continue
        row = t % LENGTH
        if rows[i, 2] > 0.5 and t >= w.localised_at[h, row]:
            w.localised[h, row] = rows[i, 3:6]
            w.localised_at[h, row] = t
        if rows[i, 6] > 0.5 and t >= w.related_at[h, row]:
            w.related[h, row] = rows[i, 7:9]
            w.related_at[h, row] = t


@kernel
def newest_rows(w: Window, hops: int, out: FloatArray) -> int:
    """The last KEPT measurement stamps of the own robot and of `hops` - 1 upstream, for a plan.

    Args:
        w: the estimator.
        hops: robots.
        out: (hops * KEPT, COLUMNS), result.

    Returns:
        How many rows of `out` are used.
    """
    count = 0
    for h in range(min(hops, len(w.until))):
        found, t = 0, w.until[h]
        last = max(t - LENGTH + 1, 0)
        while t >= last and found < KEPT:
            row = t % LENGTH
            located, related = w.localised_at[h, row] == t, w.related_at[h, row] == t
            if located or related:
                out[count, 0], out[count, 1] = h, t
                out[count, 2], out[count, 6] = 1.0 if located else 0.0, 1.0 if related else 0.0
                for c in range(3):
                    out[count, 3 + c] = w.localised[h, row, c] if located else 0.0
                for c in range(2):
                    out[count, 7 + c] = w.related[h, row, c] if related else 0.0
                count += 1
                found += 1
            t -= 1
    return count


@kernel
def between_rows(row: int, table: Table) -> int:
    """A row that the table has: the nearest to `row`."""
    return min(max(row, 0), len(table.inputs) - 1)


@kernel
def guess(h: int, t: int, table: Table, plan: Heard) -> tuple[float, float]:
    """Odometry of block h at tick t beyond what was heard: from its plan, less its disturbance, else from its slot."""
    if h == 1 and plan.here:
        after = t - plan.begins
        if after < -1e-9:
            return plan.twist[0] - plan.disturbance[0], plan.twist[1] - plan.disturbance[1]
        j = int(after / plan.stride + 1e-9)
        if j < len(plan.inputs):
            return plan.inputs[j, 0] - plan.disturbance[0], plan.inputs[j, 1] - plan.disturbance[1]
    row = between_rows(t - table.first, table)
    return table.inputs[row, h, 0], table.inputs[row, h, 1]


@kernel
def advance(
    w: Window,
    core: Core,
    to: int,
    table: Table,
    lagged: Table,
    lag: float,
    plan: Heard,
    mode: int,
    ring: int,
    q: Tuning,
) -> None:
    """Bring base or copy to tick `to`, with every measurement on the way. See `update`."""
    blocks = len(w.until)
    for t in range(core.tick[0], to):
        for h in range(blocks):
            speed = abs(table.inputs[between_rows(t - table.first, table), h, 0])
            if t < w.until[h] and t >= w.until[h] - LENGTH:
                v, omega = w.odometry[h, t % LENGTH, 0], w.odometry[h, t % LENGTH, 1]
                along, across, turn = q.along * abs(v) + q.along_least, 0.001, q.gyro
            else:
                v, omega = guess(h, t, table, plan)
                extra = UNHEARD if mode == SIGHT else GUESSED
                along = math.hypot(q.along * abs(v) + q.along_least, extra[0])
                across, turn = math.hypot(0.001, extra[1]), math.hypot(q.gyro, extra[2])
            predict(core, h, v, omega, along, across, turn, speed, q.dt)
        _correct(w, core, t + 1, lagged, lag, mode, ring, q)
    core.tick[0] = max(to, core.tick[0])


@kernel
def _correct(w: Window, core: Core, stamp: int, lagged: Table, lag: float, mode: int, ring: int, q: Tuning) -> None:
    """Every measurement of this stamp; and where a neighbour's are overdue, that it is in its slot."""
    blocks, row = len(w.until), stamp % LENGTH
    for h in range(blocks):
        if w.localised_at[h, row] == stamp:
            found = localise(core, h, w.localised[h, row], q)
            if found and h == 0:
                w.alarm[0] = max(w.alarm[0], stamp)
    if q.var_relative > 0.0 and blocks > 1:
        for h in range(blocks):
            if w.related_at[h, row] == stamp and (h + 1 < blocks or blocks == ring):
                found = relate(core, h, (h + 1) % blocks, w.related[h, row], q)
                if found and h == 0:
                    w.alarm[0] = max(w.alarm[0], stamp)
    if stamp % q.period == 0:
        slot = np.empty(3)
        for h in range(1, blocks):
            silent = mode == SIGHT or stamp > w.until[h] - q.late + OVERDUE
            if silent and w.localised_at[h, row] != stamp and _calm(core, 0) and _calm(core, h):
                at = stamp - round(lag / q.dt) if mode != SIGHT else stamp
                slot_at(lagged.slots[:, h], max(at - lagged.first, 0), slot)
                for c in range(2):
                    scalar(core, 6 * h + c, slot[c] - core.mean[h, c], IN_SLOT**2)
                if mode == SIGHT:
                    scalar(core, 6 * h + 2, wrap_small(slot[2] - core.mean[h, 2]), IN_SLOT_HEADING**2)


@kernel
def _calm(core: Core, h: int) -> bool:
    o = 6 * h
    return bool(core.cov[o + 3, o + 3] < CALM * CALM and core.cov[o + 4, o + 4] < CALM * CALM)


@kernel
def update(w: Window, table: Table, lagged: Table, lag: float, plan: Heard, mode: int, ring: int, q: Tuning) -> None:
    """Take in all that has arrived; afterwards `estimate(w)` stands at the own newest stamp.

    Args:
        w: changed.
        table: the reference by the clock around now.
        lagged: the same around the own reference time, at which a silent neighbour is believed to be in its slot.
        lag: how far that is behind the clock [s].
        plan: the newest of the upstream neighbour.
        mode: HEARD or SIGHT.
        ring: number of robots in the ring; as many blocks close it.
        q: constants.
    """
    newest = max(w.newest[0], w.until[0] - LENGTH + ROOM)
    to = newest
    if mode != SIGHT:
        for h in range(1, len(w.until)):
            to = min(to, w.until[h] - q.late)
        to = max(to, newest - BACK)
    advance(w, base(w), to, table, lagged, lag, plan, mode, ring, q)
    copy(base(w), estimate(w))
    advance(w, estimate(w), newest, table, lagged, lag, plan, mode, ring, q)


@kernel
def roll_on(w: Window, to: int, out: FloatArray, dt: float) -> None:
    """The own pose at tick `to`, not after now: the estimate carried on along odometry; into out (3,)."""
    core = estimate(w)
    m = core.mean[0]
    x, y, theta = m[0], m[1], m[2]
    for t in range(core.tick[0], to):
        v, omega = w.odometry[0, t % LENGTH, 0] + m[DV], w.odometry[0, t % LENGTH, 1] + m[DW]
        middle = theta + 0.5 * dt * omega
        x, y, theta = step(x, y, theta, v, omega, dt)
        x -= dt * m[DL] * math.sin(middle)
        y += dt * m[DL] * math.cos(middle)
    out[0], out[1], out[2] = x, y, theta
