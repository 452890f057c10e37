"""The best response as Python calls it: one call a plan (docs/theory.md, section 14).

It puts together what one Gauss-Newton step (agents/kernels/response.py) needs: the last plan moved on, the edges to the
neighbours, slots turned against the drift; and then what the plan says of waiting (agents/kernels/waiting.py).
"""

import math

import numpy as np

from agents.kernels.drifting import between
from agents.kernels.jit import (
    FLAG,
    MATRIX,
    MATRIX_OUT,
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
from agents.kernels.response import Lag, Stage, Targets, respond
from agents.kernels.unicycle import shift, step
from agents.kernels.waiting import honest, known, remember
from agents.kernels.waiting_state import RATE, WAITS, wait_of
from formation.arrays import FloatArray, IntArray

OWN, UPSTREAM, DOWNSTREAM = 0, 1, 3
"""Columns of the reference over the horizon."""
SLOW = 0.01
"""Speed of a slot below which its heading is not turned against a drift [m/s]."""
WORK_COLUMNS = 24


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
def _turned(slots: FloatArray, targets: FloatArray, lateral: float) -> None:
    """Turn the headings of slots (N + 1, 3) against a lateral drift [m/s], so that the robot moves along them."""
    for j in range(len(slots)):
        speed = targets[min(j, len(targets) - 1), 0]
        if abs(speed) > SLOW:
            slots[j, 2] -= math.atan(between(lateral / speed, -0.5, 0.5))


@kernel
def _held(nominal: FloatArray, limits: FloatArray, inputs: FloatArray, motion: FloatArray) -> None:
    """For want of a solution: the last plan, moved on and within the limits."""
    for j in range(len(nominal)):
        for c in range(2):
            value = 0.0 if math.isnan(nominal[j, c]) else between(nominal[j, c], -limits[c], limits[c])
            inputs[j, c] = motion[j, c] = value


@kernel_for(
    several(FLAG, REAL, FLAG, WHOLE),
    *(VECTOR_OUT, WHOLE_VECTOR_OUT, TABLE, TABLE, VECTOR, VECTOR, VECTOR),
    *(REAL, VECTOR, MATRIX, VECTOR) * 2,
    *(REAL, VECTOR_OUT, VECTOR_OUT, REAL, REAL, REAL, REAL, FLAG, MATRIX),
    *(MATRIX_OUT, MATRIX_OUT, MATRIX_OUT, MATRIX_OUT),
)
def plan_response(
    real: FloatArray,
    whole: IntArray,
    slots: FloatArray,
    inputs: FloatArray,
    pose: FloatArray,
    speed: FloatArray,
    disturbance: FloatArray,
    up_edge: float,
    up_pose: FloatArray,
    up_inputs: FloatArray,
    up_drift: FloatArray,
    down_edge: float,
    down_pose: FloatArray,
    down_inputs: FloatArray,
    down_drift: FloatArray,
    place: float,
    costs: FloatArray,
    limits: FloatArray,
    keep: float,
    blend: float,
    interval: float,
    moved_on: float,
    begun: bool,
    last: FloatArray,
    work: FloatArray,
    out: FloatArray,
    motion: FloatArray,
    news: FloatArray,
) -> tuple[bool, float, bool, int]:
    """The plan of one robot.

    Args:
        real, whole: its waiting, see waiting_state.FlatWait; changed.
        slots, inputs: (N + 1, 4, 3), (N, 4, 2) the reference over the horizon, see controllers.task.HorizonReference.
        pose: (3,) where the plan begins.
        speed: (2,) of the wheels there [m/s, rad/s].
        disturbance: (3,) d_v, d_l, d_w [m/s, m/s, rad/s].
        up_edge: weight of the edge to the upstream neighbour [1/m2]; 0 for none.
        up_pose, up_inputs, up_drift: (3,), (N, 2), (2,) of that neighbour, see errors_along.
        down_edge, down_pose, down_inputs, down_drift: the same of the downstream neighbour.
        place: weight of the own slot [1/m2].
        costs, limits: (2,) see response.Stage.
        keep, blend: see response.Lag.
        interval: Delta_T [s].
        moved_on: time from one plan to the next [s].
        begun: whether there is a last plan.
        last: (N, 2) its inputs.
        work: (N + 1, WORK_COLUMNS) scratch.
        out: (N, 2), result: inputs to command.
        motion: (N, 2), result: mean body velocities for the plan, no faster than the robot got lately while it waits.
        news: (n, 4), result: see waiting.known.

    Returns:
        Whether the step succeeded (else the last plan is held); rate and flag of the own waiting; how many rows of
        `news` are used.
    """
    steps = len(inputs)
    own, targets, nominal = np.empty((steps + 1, 3)), np.empty((steps, 2)), np.empty((steps, 2))
    for j in range(steps + 1):
        own[j, 0], own[j, 1], own[j, 2] = slots[j, OWN, 0], slots[j, OWN, 1], slots[j, OWN, 2]
    for j in range(steps):
        for c in range(2):
            targets[j, c] = nominal[j, c] = inputs[j, OWN, c]
    if begun:
        shift(last, moved_on, interval, targets, nominal)
    direction, error = np.zeros((2, steps + 1, 2)), np.zeros((2, steps + 1))
    edge, drift, start = np.empty(2), np.empty(2), np.empty(5)
    edge[0], edge[1] = up_edge, down_edge
    if up_edge > 0.0:
        errors_along(up_pose, up_inputs, up_drift, slots[:, UPSTREAM], own, interval, direction[0], error[0])
    if down_edge > 0.0:
        errors_along(down_pose, down_inputs, down_drift, slots[:, DOWNSTREAM], own, interval, direction[1], error[1])
    lateral, theta = disturbance[1], pose[2]
    drift[0], drift[1] = -lateral * math.sin(theta), lateral * math.cos(theta)
    if lateral != 0.0:
        _turned(own, targets, lateral)
    start[0], start[1], start[2] = pose[0], pose[1], pose[2]
    start[3], start[4] = speed[0] + disturbance[0], speed[1] + disturbance[2]
    goals, stage = Targets(own, targets, direction, error, drift), Stage(place, edge, 1.0, costs, limits)
    change = respond(start, nominal, goals, stage, Lag(keep, blend), interval, work, out, motion)
    converged = math.isfinite(change)
    if not converged:
        _held(nominal, limits, out, motion)
    wait = wait_of(real, whole)
    remember(wait, pose, motion, drift)
    honest(wait, motion)
    return converged, wait.real[RATE], wait.whole[WAITS] == 1, known(wait, news)
