"""The pair's game, compiled: its cost, and one Gauss-Newton step towards its equilibrium (docs/theory.md, section 5).

With e = slot - pose for robot i and its upstream neighbour, the residuals are the mean of both position errors
(the virtual centre), their difference along and across the desired edge (the pattern), and the mean and the
half-difference of the heading errors. The stage cost is e' W e / 2 with a 6 x 6 matrix W that turns with the edge.
"""

import math

import numpy as np

from agents.kernels import lq
from agents.kernels.jit import MATRIX, MATRIX_OUT, NOTHING, REAL, TABLE, TABLE_OUT, VECTOR, inlined, kernel, kernel_for
from agents.kernels.unicycle import move
from formation.arrays import FloatArray

_backward, _forward = lq.backward, lq.forward


@inlined
def _add_weight(q: FloatArray, slots: FloatArray, i: int, other: int, w: FloatArray) -> None:
    """Add the W of one pair to w (3n, 3n), for coordinates (x, y, theta) of all robots.

    Args:
        q: (6,) centre, centre, mean heading, radial, tangential, half-difference of headings.
        slots: (n, 3); the desired edge leads from robot i to `other`.
        i, other: rows of the pair.
        w: is added to.
    """
    nx, ny = slots[other, 0] - slots[i, 0], slots[other, 1] - slots[i, 1]
    distance = math.hypot(nx, ny)
    nx, ny = nx / distance, ny / distance
    radial, tangential = q[3], q[4] / (distance * distance)
    dxx = radial * nx * nx + tangential * ny * ny
    dxy = (radial - tangential) * nx * ny
    dyy = radial * ny * ny + tangential * nx * nx
    for a in range(2):
        for b in range(2):
            sign = 1.0 if a == b else -1.0
            row, column = 3 * (i if a == 0 else other), 3 * (i if b == 0 else other)
            w[row, column] += 0.25 * q[0] + sign * dxx
            w[row, column + 1] += sign * dxy
            w[row + 1, column] += sign * dxy
            w[row + 1, column + 1] += 0.25 * q[1] + sign * dyy
            w[row + 2, column + 2] += 0.25 * (q[2] + sign * q[5])


@kernel_for(NOTHING, TABLE, VECTOR, TABLE_OUT)
def ring_weights(slots: FloatArray, q: FloatArray, weights: FloatArray) -> None:
    """W_j of sum_i J_i: the cost of every robot and its upstream neighbour, added up over the ring.

    Args:
        slots: (N + 1, n, 3) slot poses; the desired edges are those between them.
        q: (6,) as of `improve`.
        weights: out, (N + 1, 3n, 3n).
    """
    n = slots.shape[1]
    weights[:] = 0.0
    for j in range(len(slots)):
        for i in range(n):
            _add_weight(q, slots[j], i, (i + n - 1) % n, weights[j])


@kernel
def _pair_weights(slots: FloatArray, q: FloatArray) -> FloatArray:
    """W_j (N + 1, 6, 6) of robot i and its upstream neighbour."""
    weights = np.zeros((len(slots), 6, 6))
    for j in range(len(slots)):
        _add_weight(q, slots[j], 0, 1, weights[j])
    return weights


@kernel_for(REAL, VECTOR, MATRIX, TABLE, TABLE, REAL, VECTOR, VECTOR)
def cost(
    x0: FloatArray,
    u: FloatArray,
    slots: FloatArray,
    targets: FloatArray,
    dt: float,
    q: FloatArray,
    r: FloatArray,
) -> float:
    """The cost J_i, eq. (4) with inputs relative to their targets, of playing u (N, 4) from x0 (6,). See `improve`."""
    return float(lq.cost(x0, u, slots, targets, _pair_weights(slots, q), r, dt))


@kernel_for(REAL, VECTOR, MATRIX, TABLE, TABLE, REAL, VECTOR, VECTOR, VECTOR, MATRIX_OUT)
def improve(
    x0: FloatArray,
    nominal: FloatArray,
    slots: FloatArray,
    targets: FloatArray,
    dt: float,
    q: FloatArray,
    r: FloatArray,
    limits: FloatArray,
    out: FloatArray,
) -> float:
    """One Gauss-Newton step of the pair's game: Riccati backwards, eq. (10), roll-out forwards within limits.

    Args:
        x0: (6,) poses of robot i and its upstream neighbour.
        nominal: (N, 4) inputs of both to linearise along.
        slots, targets: (N + 1, 2, 3) and (N, 2, 2), poses and inputs of both slots over the horizon.
        dt: Delta_T [s].
        q: (6,) weights of centre, centre, mean heading, radial, tangential, half-difference of headings.
        r: (4,) weights of both robots' inputs.
        limits: (2,) of |v| and |omega|.
        out: (N, 4), the inputs of both players at the (linearised) equilibrium.

    Returns:
        The largest change of an input against `nominal`; NaN if the step failed.
    """
    steps = len(nominal)
    x, rolled, gains = np.empty((steps + 1, 6)), np.empty((steps + 1, 6)), np.empty((steps, 4, 7))
    x[0] = x0
    rolled[0] = x0
    for j in range(steps):
        move(x[j], nominal[j], dt, x[j + 1])
    weights = _pair_weights(slots, q)
    _backward(x, nominal, slots, targets, weights, r, dt, limits, False, 2, gains)
    return float(_forward(x, nominal, gains, 1.0, dt, limits, 2, rolled, out))
