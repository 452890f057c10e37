"""Compiled numerics of one unicycle: motion, its derivatives, and carrying a plan forward in time."""

import math

from agents.kernels.jit import (
    NOTHING,
    REAL,
    STRIDED,
    STRIDED_OUT,
    TABLE,
    TABLE_OUT,
    VECTOR,
    VECTOR_OUT,
    inlined,
    kernel,
    kernel_for,
)
from formation import unicycle
from formation.arrays import FloatArray

step = kernel(unicycle.step)
wrap = kernel(unicycle.wrap)


@kernel
def clip(value: float, limit: float) -> float:
    """Value held within +- limit."""
    return min(max(value, -limit), limit)


@kernel
def derivatives(theta: float, v: float, omega: float, dt: float) -> tuple[float, float, float, float, float, float]:
    """Derivatives of unicycle.step: of x and y by theta, by v, and by omega.

    Returns:
        (dx/dtheta, dy/dtheta, dx/dv, dy/dv, dx/domega, dy/domega). That of theta is 1, 0, dt.
    """
    half = 0.5 * omega * dt
    if abs(half) < unicycle.SMALL_TURN:
        ratio, slope = 1.0 - half * half / 6.0, -half / 3.0  # sin(h)/h and its derivative
    else:
        ratio = math.sin(half) / half
        slope = (math.cos(half) - ratio) / half
    c, s = math.cos(theta + half), math.sin(theta + half)
    chord, bend = v * dt * ratio, 0.5 * v * dt * dt * slope
    return (
        -chord * s,
        chord * c,
        dt * ratio * c,
        dt * ratio * s,
        bend * c - 0.5 * dt * chord * s,
        bend * s + 0.5 * dt * chord * c,
    )


@kernel
def move(x: FloatArray, u: FloatArray, dt: float, out: FloatArray) -> None:
    """n robots (3n,) one interval on under u (2n,)."""
    for i in range(len(u) // 2):
        out[3 * i], out[3 * i + 1], out[3 * i + 2] = step(
            x[3 * i], x[3 * i + 1], x[3 * i + 2], u[2 * i], u[2 * i + 1], dt
        )


@inlined
def linearise(x: FloatArray, u: FloatArray, dt: float, g: FloatArray) -> None:
    """`derivatives` of n robots at x (3n,), u (2n,) into g (n, 6): all of the Jacobians A and B of `move`."""
    for i in range(len(g)):
        g[i, 0], g[i, 1], g[i, 2], g[i, 3], g[i, 4], g[i, 5] = derivatives(x[3 * i + 2], u[2 * i], u[2 * i + 1], dt)


@inlined
def times_input(p: FloatArray, g: FloatArray, dt: float, out: FloatArray) -> None:
    """out (rows, 2n) = p (rows, 3n) B, with g of `linearise`."""
    for a in range(len(p)):
        for i in range(len(g)):
            px, py, pt = p[a, 3 * i], p[a, 3 * i + 1], p[a, 3 * i + 2]
            out[a, 2 * i] = px * g[i, 2] + py * g[i, 3]
            out[a, 2 * i + 1] = px * g[i, 4] + py * g[i, 5] + pt * dt


@inlined
def times_state(p: FloatArray, g: FloatArray) -> None:
    """p (rows, 3n) <- p A in place, with g of `linearise`: only the columns of the headings change."""
    for a in range(len(p)):
        for i in range(len(g)):
            p[a, 3 * i + 2] += p[a, 3 * i] * g[i, 0] + p[a, 3 * i + 1] * g[i, 1]


@kernel_for(NOTHING, STRIDED, REAL, REAL, STRIDED, STRIDED_OUT)
def shift(inputs: FloatArray, elapsed: float, interval: float, tail: FloatArray, out: FloatArray) -> None:
    """A plan's inputs on the grid that begins `elapsed` after the plan: out[j] is the mean over interval j.

    Args:
        inputs: (N, 2) held for `interval` each.
        elapsed: time since the plan's stamp [s], not negative.
        interval: Delta_T [s].
        tail: (N, 2) inputs on the new grid for when the plan has ended.
        out: (N, 2).
    """
    steps = len(inputs)
    whole = int(elapsed / interval + 1e-9)
    part = max(elapsed / interval - whole, 0.0)
    for j in range(steps):
        for c in range(2):
            now = inputs[j + whole, c] if j + whole < steps else tail[j, c]
            later = inputs[j + whole + 1, c] if j + whole + 1 < steps else tail[j, c]
            out[j, c] = (1.0 - part) * now + part * later


@kernel
def _input(inputs: FloatArray, k: int, part: float, i: int, c: int) -> float:
    """Column c of input i of a table (T, n, 2), `part` of the way from row k to the next."""
    if part < 1e-9:
        return float(inputs[k, i, c])
    return float((1.0 - part) * inputs[k, i, c] + part * inputs[k + 1, i, c])


@kernel
def _slot(slots: FloatArray, k: int, part: float, i: int) -> tuple[float, float, float]:
    """Slot i of a table (T, n, 3), `part` of the way from row k to the next."""
    x, y, theta = slots[k, i, 0], slots[k, i, 1], slots[k, i, 2]
    if part < 1e-9:
        return x, y, theta
    x, y = (1.0 - part) * x + part * slots[k + 1, i, 0], (1.0 - part) * y + part * slots[k + 1, i, 1]
    return x, y, theta + part * wrap(slots[k + 1, i, 2] - theta)


@kernel_for(NOTHING, TABLE, TABLE, REAL, REAL, REAL, TABLE_OUT, TABLE_OUT)
def sample(
    slots: FloatArray,
    inputs: FloatArray,
    row: float,
    stride: float,
    pace: float,
    out_slots: FloatArray,
    out_inputs: FloatArray,
) -> None:
    """The reference over a horizon, from tables by tick.

    Args:
        slots, inputs: tables (T, n, 3) and (T, n, 2).
        row: where the horizon begins; between rows is interpolated.
        stride: rows from one of its points to the next, at pace 1.
        pace: rate of the reference time.
        out_slots: (N + 1, n, 3).
        out_inputs: (N, n, 2).
    """
    for j in range(len(out_slots)):
        at = row + j * stride * pace
        k = min(int(at + 1e-9), len(slots) - 2)
        part = max(at - k, 0.0)
        for i in range(slots.shape[1]):
            out_slots[j, i, 0], out_slots[j, i, 1], out_slots[j, i, 2] = _slot(slots, k, part, i)
            if j < len(out_inputs):
                for c in range(2):
                    out_inputs[j, i, c] = pace * _input(inputs, k, part, i, c)


@kernel
def sample_slots(slots: FloatArray, row: float, stride: float, pace: float, column: int, out: FloatArray) -> None:
    """The slots, out (N + 1, 3), that `sample` gives of one column."""
    for j in range(len(out)):
        at = row + j * stride * pace
        k = min(int(at + 1e-9), len(slots) - 2)
        part = max(at - k, 0.0)
        out[j, 0], out[j, 1], out[j, 2] = _slot(slots, k, part, column)


@kernel
def sample_inputs(inputs: FloatArray, row: float, stride: float, pace: float, column: int, out: FloatArray) -> None:
    """The inputs, out (N, 2), that `sample` gives of one column."""
    for j in range(len(out)):
        at = row + j * stride * pace
        k = min(int(at + 1e-9), len(inputs) - 2)
        part = max(at - k, 0.0)
        for c in range(2):
            out[j, c] = pace * _input(inputs, k, part, column, c)


@kernel_for(NOTHING, VECTOR, STRIDED, REAL, REAL, VECTOR_OUT)
def age(pose: FloatArray, inputs: FloatArray, elapsed: float, interval: float, out: FloatArray) -> None:
    """The pose (3,) that a plan predicts `elapsed` after its stamp, at most to the plan's end; into out (3,)."""
    x, y, theta = pose[0], pose[1], pose[2]
    left = elapsed
    for j in range(len(inputs)):
        if left <= 1e-12:
            break
        x, y, theta = step(x, y, theta, inputs[j, 0], inputs[j, 1], min(left, interval))
        left -= interval
    out[0], out[1], out[2] = x, y, theta
