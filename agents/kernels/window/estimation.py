"""The estimator as Python calls it: odometry, measurements and plans in, an estimate out, a call each.

Every call takes the flat arrays of the state (FlatWindow, Motors) and puts results into arrays of its caller.
"""

import math

from agents.kernels.jit import (
    FLAG,
    MATRIX,
    MATRIX_OUT,
    NOTHING,
    REAL,
    TABLE,
    VECTOR,
    VECTOR_OUT,
    WHOLE,
    WHOLE_VECTOR_OUT,
    entry_for,
    kernel,
    several,
)
from agents.kernels.learning import learn, motors_of
from agents.kernels.window.filter import Heard, Table, hear, newest_rows, update
from agents.kernels.window.look_ahead import look_ahead, neighbour_ahead
from agents.kernels.window.state import DL, LENGTH, Window, tuning_of, window_of
from formation.arrays import FloatArray, IntArray

POSE, SPEED, TWIST, INPUT_DISTURBANCE, DRIFT = slice(0, 3), slice(3, 5), slice(5, 7), slice(7, 9), slice(9, 11)
DISTURBANCE, NEIGHBOUR, NEIGHBOUR_DRIFT = slice(11, 14), slice(14, 17), slice(17, 19)
DRIFT_SIGMA, RESULTS = 19, 20
"""Where `estimate` puts what agents.estimator.Estimate describes; pose and drift of the neighbour that is seen, and the
standard deviation of the own d_l [m/s]. RESULTS is their number."""


@kernel
def _sense(w: Window, tick: int, located: bool, pose: FloatArray, related: bool, relative: FloatArray) -> None:
    row = tick % LENGTH
    if tick < w.until[0] - LENGTH:
        return
    if located and tick >= w.localised_at[0, row]:
        for c in range(3):
            w.localised[0, row, c] = pose[c]
        w.localised_at[0, row] = tick
        w.newest[0] = max(w.newest[0], tick)
    if related and tick >= w.related_at[0, row]:
        for c in range(2):
            w.related[0, row, c] = relative[c]
        w.related_at[0, row] = tick
        w.newest[0] = max(w.newest[0], tick)


@entry_for(
    FLAG,
    *(VECTOR_OUT, WHOLE_VECTOR_OUT, VECTOR_OUT, WHOLE, VECTOR, VECTOR, REAL, FLAG),
    *(WHOLE, FLAG, VECTOR, FLAG, VECTOR),
)
def roll(
    real: FloatArray,
    whole: IntArray,
    motors: FloatArray,
    k: int,
    before: FloatArray,
    after: FloatArray,
    dt: float,
    learns: bool,
    tick: int,
    located: bool,
    pose: FloatArray,
    related: bool,
    relative: FloatArray,
) -> bool:
    """Take the own odometry of tick k - 1, which has just ended, and then a measurement.

    Args:
        real, whole: the window, changed.
        motors: changed, if it learns.
        k: now.
        before, after: (2,) wheel speeds of tick k - 2 and k - 1 [m/s, rad/s].
        dt: [s].
        learns: whether delay and lag are learnt from it.
        tick, located, pose, related, relative: see sense; neither located nor related: there is no measurement.

    Returns:
        Whether the motors' model changed.
    """
    w = window_of(real, whole)
    row = (k - 1) % LENGTH
    for c in range(2):
        w.odometry[0, row, c] = after[c]
        w.sums[0, c] += after[c] * dt
    w.until[0] = k
    _sense(w, tick, located, pose, related, relative)
    return learns and learn(motors_of(motors), k - 1, before, after, dt)


@entry_for(NOTHING, VECTOR_OUT, WHOLE_VECTOR_OUT, WHOLE, FLAG, VECTOR, FLAG, VECTOR)
def sense(
    real: FloatArray,
    whole: IntArray,
    tick: int,
    located: bool,
    pose: FloatArray,
    related: bool,
    relative: FloatArray,
) -> None:
    """Take the own measurement of a tick: pose (3,) if it is located, relative (2,) if it is related to its neighbour.

    What is older than another measurement of its row changes nothing.
    """
    _sense(window_of(real, whole), tick, located, pose, related, relative)


@entry_for(NOTHING, VECTOR_OUT, WHOLE_VECTOR_OUT, MATRIX, MATRIX, REAL)
def take(real: FloatArray, whole: IntArray, odometry: FloatArray, rows: FloatArray, dt: float) -> None:
    """Take what the upstream neighbour's plan carries; see filter.hear."""
    hear(window_of(real, whole), odometry, rows, dt)


@kernel
def _drift(lateral: float, pose: FloatArray, out: FloatArray) -> None:
    """A lateral velocity at a pose (3,) in the world frame, out (2,) [m/s]."""
    out[0], out[1] = -lateral * math.sin(pose[2]), lateral * math.cos(pose[2])


@entry_for(
    several(WHOLE, WHOLE, WHOLE),
    VECTOR_OUT,
    WHOLE_VECTOR_OUT,
    VECTOR_OUT,
    VECTOR,
    *(TABLE, TABLE, WHOLE) * 2,
    REAL,
    *(REAL, REAL, MATRIX, VECTOR, VECTOR),
    *(WHOLE, WHOLE, REAL, WHOLE, WHOLE, VECTOR),
    *(VECTOR_OUT, MATRIX_OUT, MATRIX_OUT, MATRIX_OUT),
)
def estimate(
    real: FloatArray,
    whole: IntArray,
    motors: FloatArray,
    tuning: FloatArray,
    slots: FloatArray,
    inputs: FloatArray,
    first: int,
    late_slots: FloatArray,
    late_inputs: FloatArray,
    late_first: int,
    lag: float,
    begins: float,
    interval: float,
    heard: FloatArray,
    heard_twist: FloatArray,
    heard_disturbance: FloatArray,
    k: int,
    delay: int,
    rate: float,
    mode: int,
    ring: int,
    speed: FloatArray,
    out: FloatArray,
    covariance: FloatArray,
    odometry: FloatArray,
    rows: FloatArray,
) -> tuple[int, int, int]:
    """Take in all that has arrived; the robot, and its neighbour if it is seen, where a plan made at tick k begins.

    Args:
        real, whole: the window, changed.
        motors: see learning.Motors.
        tuning: constants, see state.Tuning.
        slots, inputs, first: the reference by the clock around now, see filter.Table.
        late_slots, late_inputs, late_first: the same around the own reference time.
        lag: how far that is behind the clock [s].
        begins, interval, heard, heard_twist, heard_disturbance: the newest plan of the upstream neighbour: where its
            horizon begins [s] (-inf without a plan), and see network.messages.Plan.
        k: now.
        delay: ticks from a command to its effect.
        rate: see look_ahead.
        mode, ring: see filter.update.
        speed: (2,) of the wheels now [m/s, rad/s].
        out: (RESULTS,), result.
        covariance: (3, 3), result: of the pose, see agents.estimator.Estimate.
        odometry: (H, 4), result: what Plan.odometry carries; H is 0 for a robot that passes nothing on.
        rows: (H * KEPT, COLUMNS), result: what Plan.measurements carries.

    Returns:
        How many of `rows` are used; localisations rejected in a row; stamp of the newest own alarm [ticks].
    """
    w, q = window_of(real, whole), tuning_of(tuning)
    dt = q.dt
    here = (k + delay) * dt - begins < len(heard) * interval
    plan = Heard(here, begins / dt, interval / dt, heard, heard_twist, heard_disturbance)
    table = Table(slots, inputs, first)
    update(w, table, Table(late_slots, late_inputs, late_first), lag, plan, mode, ring, q)
    for c in range(2):
        out[SPEED.start + c] = speed[c]
    look_ahead(w, motors_of(motors), k, delay, rate, dt, out[POSE], out[SPEED], out[TWIST])
    m, cov = w.copy_mean[0], w.copy_cov
    for c in range(3):
        out[DISTURBANCE.start + c] = m[3 + c]
    for c in range(2):
        out[INPUT_DISTURBANCE.start + c] = m[3 + 2 * c]
    _drift(m[DL], out[POSE], out[DRIFT])
    for a in range(3):
        for b in range(3):
            covariance[a, b] = cov[a, b]
    out[DRIFT_SIGMA] = math.sqrt(max(cov[DL, DL], 0.0))
    if len(w.until) > 1:
        neighbour_ahead(w, k + delay, table, plan, dt, out[NEIGHBOUR])
        _drift(w.copy_mean[1, DL], out[NEIGHBOUR], out[NEIGHBOUR_DRIFT])
    hops = len(odometry)
    for h in range(hops):
        odometry[h, 0], odometry[h, 1], odometry[h, 2], odometry[h, 3] = (
            w.sums[h, 0],
            w.sums[h, 1],
            w.until[h],
            w.sums[h, 2],
        )
    return newest_rows(w, hops, rows), w.copy_rejected[0, 0], w.alarm[0]
