"""The best response as Python calls it: one call a plan (docs/theory.md, section 14).

It decides on waiting (agents/kernels/attend.py), puts together what one Gauss-Newton step (agents/kernels/response.py)
needs: the last plan moved on, the edges to the neighbours by the trust in their plans, slots turned against the drift;
and then what the plan says of waiting (agents/kernels/waiting.py).
"""

import math

from agents.kernels.attend import attend, trust_in
from agents.kernels.drifting import believed, between, turned
from agents.kernels.jit import (
    FLAG,
    MATRIX,
    MATRIX_OUT,
    REAL,
    TABLE,
    TABLE_OUT,
    VECTOR,
    VECTOR_OUT,
    WHOLE,
    WHOLE_VECTOR_OUT,
    entry_for,
    kernel,
    several,
)
from agents.kernels.nearby.separation import ROOM, astray, caution, courses, met
from agents.kernels.planner import (
    BEGUN,
    INTERVAL,
    SOURCES,
    SPACING,
    SQUARE,
    STEP,
    STRIDE,
    TICK,
    TRUST_TIME,
    WEIGHT,
    planner_of,
)
from agents.kernels.response import Lag, Stage, Targets, respond
from agents.kernels.unicycle import sample_inputs, sample_slots, shift, step
from agents.kernels.waiting import honest, known, remember
from agents.kernels.waiting_state import LAG, PACE, RATE, WAITS, wait_of
from agents.kernels.window.state import LEVELS
from formation.arrays import FloatArray, IntArray

OWN, UPSTREAM, DOWNSTREAM = 0, 1, 3
"""Columns of the reference over the horizon."""
SHARED = 0.25
"""Weight of the own slot while neighbours are trusted, as a share of that without."""
MOST_NOISE = 0.25 * LEVELS[1]
"""Largest noise of a drift across the heading that is believed in [m/s]: just after the filter has detected a
disturbance its standard deviation is large, and then the drift is to be believed."""


@kernel
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


@kernel
def _held(nominal: FloatArray, limits: FloatArray, inputs: FloatArray, motion: FloatArray) -> None:
    """For want of a solution: the last plan, moved on and within the limits."""
    for j in range(len(nominal)):
        for c in range(2):
            value = 0.0 if math.isnan(nominal[j, c]) else between(nominal[j, c], -limits[c], limits[c])
            inputs[j, c] = motion[j, c] = value


@entry_for(
    several(FLAG, REAL, REAL, FLAG, FLAG, REAL, FLAG, WHOLE),
    *(VECTOR_OUT, WHOLE_VECTOR_OUT, VECTOR_OUT, TABLE, TABLE, REAL, REAL, REAL),
    *(FLAG, FLAG, WHOLE, TABLE, TABLE, WHOLE, REAL),
    *(WHOLE, VECTOR, VECTOR, VECTOR, REAL, MATRIX, WHOLE, REAL, REAL, REAL, REAL),
    *(VECTOR, MATRIX, VECTOR, MATRIX, REAL, FLAG, FLAG, FLAG) * 2,
    *(MATRIX, TABLE_OUT, MATRIX_OUT),
)
def plan_response(
    real: FloatArray,
    whole: IntArray,
    own_planner: FloatArray,
    ahead_slots: FloatArray,
    ahead_inputs: FloatArray,
    row: float,
    lag: float,
    pace: float,
    attends: bool,
    waiting: bool,
    robot: int,
    table_slots: FloatArray,
    table_inputs: FloatArray,
    first: int,
    at: float,
    k: int,
    pose: FloatArray,
    speed: FloatArray,
    disturbance: FloatArray,
    noise: float,
    covariance: FloatArray,
    rejected: int,
    gap: float,
    alarm_age: float,
    keep: float,
    blend: float,
    up_pose: FloatArray,
    up_inputs: FloatArray,
    up_drift: FloatArray,
    up_news: FloatArray,
    up_age: float,
    up_seen: bool,
    up_trusted: bool,
    up_waits: bool,
    down_pose: FloatArray,
    down_inputs: FloatArray,
    down_drift: FloatArray,
    down_news: FloatArray,
    down_age: float,
    down_seen: bool,
    down_trusted: bool,
    down_waits: bool,
    bodies: FloatArray,
    out: FloatArray,
    news: FloatArray,
) -> tuple[bool, float, float, bool, bool, float, bool, int]:
    """The plan of one robot.

    Args:
        real, whole: its waiting, see waiting_state.FlatWait; changed.
        own_planner: see planner.Planner; changed.
        ahead_slots, ahead_inputs, row: tables (T, 4, 3), (T, 4, 2) of the reference and where the horizon begins in
            them, see unicycle.sample; columns as in controllers.task.HorizonReference.
        lag, pace: of the reference time over the horizon [s].
        attends: whether it decides on waiting first. If that changes lag or pace, nothing is planned: call again with
            another reference, and what this call says of waiting.
        waiting: if it does not: whether anybody waits.
        robot, table_slots, table_inputs, first, at: see attend.attend.
        k: where the plan begins [ticks].
        pose: (3,) where the plan begins.
        speed: (2,) of the wheels there [m/s, rad/s].
        disturbance: (3,) d_v, d_l, d_w [m/s, m/s, rad/s].
        noise: of d_l, see believed [m/s].
        covariance, rejected, gap: see attend.attend.
        alarm_age: since the last detection of a disturbance of the own robot [s].
        keep, blend: see response.Lag.
        up_pose, up_inputs, up_drift: (3,), (N, 2), (2,) of the upstream neighbour, see errors_along.
        up_news, up_waits: of its plan: what it knows of waiting, and whether a fresh one says that the robot waits.
        up_age, up_seen, up_trusted: see attend.trust_in; and whether an edge to it means something.
        down_pose, ...: the same of the downstream neighbour.
        bodies: (B, BODY) near by, see sight.foresee.
        out: (2, N, 2), result: inputs to command, and mean body velocities for the plan, no faster than the robot got
            lately while it waits.
        news: (n, 4), result: see waiting.known.

    Returns:
        Whether it has planned; lag [s] and pace; whether anybody waits. If it has planned: whether the step succeeded
        (else the last plan is held); rate and flag of the own waiting; how many rows of `news` are used.
    """
    steps = out.shape[1]
    wait, plans = wait_of(real, whole), planner_of(own_planner, steps)
    constants, interval = plans.constants, plans.constants[INTERVAL]
    if attends:
        waiting = attend(
            wait,
            robot,
            float(k),
            pose,
            covariance,
            disturbance,
            rejected,
            gap,
            table_slots,
            table_inputs,
            first,
            at,
            up_news,
            down_news,
            up_waits or down_waits,
            constants[SPACING],
            plans.limits[0],
            constants[STEP],
            constants[TICK],
            interval,
        )
        if wait.real[LAG] != lag or wait.real[PACE] != pace:
            return False, wait.real[LAG], wait.real[PACE], waiting, False, 0.0, False, 0
    heard, time = constants[SOURCES] > 0.0, constants[TRUST_TIME]
    f = trust_in(up_age if heard else math.inf, up_seen, time, alarm_age, waiting) if up_trusted else 0.0
    g = trust_in(down_age if heard else math.inf, down_seen, time, alarm_age, waiting) if down_trusted else 0.0
    sources = max(constants[SOURCES], 1.0)
    trust = f / sources + g / sources
    place = constants[WEIGHT] * (SHARED + (1.0 - trust) * (1.0 - SHARED)) / constants[SQUARE]
    own, targets, nominal, other = plans.own, plans.targets, plans.nominal, plans.other
    direction, error, edge, drift, start = plans.direction, plans.error, plans.edge, plans.drift, plans.start
    stride = constants[STRIDE]
    sample_slots(ahead_slots, row, stride, pace, OWN, own)
    sample_inputs(ahead_inputs, row, stride, pace, OWN, targets)
    if constants[BEGUN] == 1.0:
        shift(plans.last, constants[STEP], interval, targets, nominal)
    else:
        for j in range(steps):
            nominal[j, 0], nominal[j, 1] = targets[j, 0], targets[j, 1]
    edge[0], edge[1] = f * constants[WEIGHT] / constants[SQUARE], g * constants[WEIGHT] / constants[SQUARE]
    if edge[0] > 0.0:
        sample_slots(ahead_slots, row, stride, pace, UPSTREAM, other)
        errors_along(up_pose, up_inputs, up_drift, other, own, interval, direction[0], error[0])
    if edge[1] > 0.0:
        sample_slots(ahead_slots, row, stride, pace, DOWNSTREAM, other)
        errors_along(down_pose, down_inputs, down_drift, other, own, interval, direction[1], error[1])
    start[0], start[1], start[2] = pose[0], pose[1], pose[2]
    start[3], start[4] = speed[0] + disturbance[0], speed[1] + disturbance[2]
    far = max(astray(own[0], pose, constants[SPACING]), met(bodies, pose, start[3])) if len(bodies) > 0 else 0.0
    plans.prices[0], plans.prices[1] = plans.costs[0] * (1.0 + caution(bodies, pose, far)), plans.costs[1]
    foreseen = courses(bodies, own[:, 2], far, interval)
    lateral, theta = believed(disturbance[1], min(noise, MOST_NOISE)), pose[2]
    drift[0], drift[1] = -lateral * math.sin(theta), lateral * math.cos(theta)
    if lateral != 0.0:
        turned(own, targets, lateral)
    goals = Targets(own, targets, direction, error, drift, foreseen)
    room = ROOM * constants[WEIGHT] / constants[SQUARE]
    stage = Stage(place, edge, 1.0, plans.prices, plans.limits, room)
    commanded, motion = out[0], out[1]
    change = respond(start, nominal, goals, stage, Lag(keep, blend), interval, plans.work, commanded, motion)
    converged = math.isfinite(change)
    if not converged:
        _held(nominal, plans.limits, commanded, motion)
    for j in range(steps):
        for c in range(2):
            plans.last[j, c] = commanded[j, c]
    constants[BEGUN] = 1.0
    remember(wait, pose, motion, drift)
    honest(wait, motion)
    return True, lag, pace, waiting, converged, wait.real[RATE], wait.whole[WAITS] == 1, known(wait, news)
