"""The pair's game as a compiled Gauss-Newton step: six coordinates, four inputs (docs/theory.md, section 5).

With e = slot - pose for robot i and its upstream neighbour, the residuals are the mean of both position errors
(the virtual centre), their difference along and across the desired edge (the pattern), and the mean and the
half-difference of the heading errors. The stage cost is e' W e / 2 with a 6 x 6 matrix W that turns with the edge.
"""

import math

import numpy as np

from agents.kernels.jit import MATRIX, MATRIX_OUT, REAL, TABLE, VECTOR, kernel, kernel_for
from agents.kernels.unicycle import clip, derivatives, step, wrap
from formation.arrays import FloatArray


@kernel
def _weight(q: FloatArray, slots: FloatArray, w: FloatArray) -> None:
    """W (6, 6) for coordinates (x, y, theta) of both robots.

    Args:
        q: see formation.scenario.Controller.q.
        slots: (2, 3); the desired edge leads from the first to the second.
        w: (6, 6), the result.
    """
    w[:] = 0.0
    nx, ny = slots[1, 0] - slots[0, 0], slots[1, 1] - slots[0, 1]
    distance = math.hypot(nx, ny)
    nx, ny = nx / distance, ny / distance
    radial, tangential = q[3], q[4] / (distance * distance)
    dxx = radial * nx * nx + tangential * ny * ny
    dxy = (radial - tangential) * nx * ny
    dyy = radial * ny * ny + tangential * nx * nx
    for a in range(2):
        for b in range(2):
            sign = 1.0 if a == b else -1.0
            w[3 * a, 3 * b] = 0.25 * q[0] + sign * dxx
            w[3 * a, 3 * b + 1] = sign * dxy
            w[3 * a + 1, 3 * b] = sign * dxy
            w[3 * a + 1, 3 * b + 1] = 0.25 * q[1] + sign * dyy
            w[3 * a + 2, 3 * b + 2] = 0.25 * (q[2] + sign * q[5])


@kernel
def _error(x: FloatArray, slots: FloatArray, e: FloatArray) -> None:
    """e (6,) = slots (2, 3) - x (6,), headings wrapped."""
    for a in range(2):
        e[3 * a] = slots[a, 0] - x[3 * a]
        e[3 * a + 1] = slots[a, 1] - x[3 * a + 1]
        e[3 * a + 2] = wrap(slots[a, 2] - x[3 * a + 2])


@kernel
def _move(x: FloatArray, u: FloatArray, dt: float, out: FloatArray) -> None:
    """Both robots (6,) one interval on under u (4,)."""
    for a in range(2):
        out[3 * a], out[3 * a + 1], out[3 * a + 2] = step(
            x[3 * a], x[3 * a + 1], x[3 * a + 2], u[2 * a], u[2 * a + 1], dt
        )


@kernel
def _quadratic(e: FloatArray, w: FloatArray) -> float:
    total = 0.0
    for a in range(6):
        for b in range(6):
            total += e[a] * w[a, b] * e[b]
    return 0.5 * total


@kernel
def _times_input(p: FloatArray, g: FloatArray, dt: float, out: FloatArray) -> None:
    """out (rows, 4) = p (rows, 6) B, where g (2, 6) holds `derivatives` of both robots."""
    for a in range(len(p)):
        for r in range(2):
            px, py, pt = p[a, 3 * r], p[a, 3 * r + 1], p[a, 3 * r + 2]
            out[a, 2 * r] = px * g[r, 2] + py * g[r, 3]
            out[a, 2 * r + 1] = px * g[r, 4] + py * g[r, 5] + pt * dt


@kernel
def _times_state(p: FloatArray, g: FloatArray) -> None:
    """p (rows, 6) <- p A in place: only the columns of the headings change."""
    for a in range(len(p)):
        for r in range(2):
            p[a, 3 * r + 2] += p[a, 3 * r] * g[r, 0] + p[a, 3 * r + 1] * g[r, 1]


@kernel
def _solve4(m: FloatArray, rhs: FloatArray) -> None:
    """rhs (4, 7) <- inverse of m (4, 4), symmetric positive definite, times rhs: Cholesky, in place."""
    for a in range(4):
        for b in range(a + 1):
            value = m[a, b]
            for c in range(b):
                value -= m[a, c] * m[b, c]
            m[a, b] = math.sqrt(value) if a == b else value / m[b, b]
    for col in range(rhs.shape[1]):
        for a in range(4):
            value = rhs[a, col]
            for c in range(a):
                value -= m[a, c] * rhs[c, col]
            rhs[a, col] = value / m[a, a]
        for a in range(3, -1, -1):
            value = rhs[a, col]
            for c in range(a + 1, 4):
                value -= m[c, a] * rhs[c, col]
            rhs[a, col] = value / m[a, a]


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
    x, e, w = x0.copy(), np.empty(6), np.empty((6, 6))
    total = 0.0
    for j in range(len(u) + 1):
        _weight(q, slots[j], w)
        _error(x, slots[j], e)
        total += _quadratic(e, w)
        if j < len(u):
            for a in range(4):
                gap = u[j, a] - targets[j, a // 2, a % 2]
                total += 0.5 * r[a] * gap * gap
            _move(x, u[j], dt, x)
    return total


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
        q, r: diagonals (6,) and (4,) of the weights.
        limits: (2,) of |v| and |omega|.
        out: (N, 4), the inputs of both players at the (linearised) equilibrium.

    Returns:
        The largest change of an input against `nominal`; NaN if the step failed.
    """
    steps = len(nominal)
    x = np.empty((steps + 1, 6))
    x[0] = x0
    for j in range(steps):
        _move(x[j], nominal[j], dt, x[j + 1])
    gains = np.empty((steps, 4, 7))  # (-K | -k)
    g, w, e = np.empty((2, 6)), np.empty((6, 6)), np.empty(6)
    p, gradient = np.empty((6, 6)), np.empty(6)
    pa, pb, btp, quu = np.empty((6, 6)), np.empty((6, 4)), np.empty((4, 6)), np.empty((4, 4))
    ga, gb, rhs = np.empty((1, 6)), np.empty((1, 4)), np.empty((4, 7))

    _weight(q, slots[steps], p)
    _error(x[steps], slots[steps], e)
    for a in range(6):
        gradient[a] = 0.0
        for b in range(6):
            gradient[a] -= p[a, b] * e[b]

    for j in range(steps - 1, -1, -1):
        for a in range(2):
            g[a, 0], g[a, 1], g[a, 2], g[a, 3], g[a, 4], g[a, 5] = derivatives(
                x[j, 3 * a + 2], nominal[j, 2 * a], nominal[j, 2 * a + 1], dt
            )
        _times_input(p, g, dt, pb)  # P B
        for a in range(6):
            for b in range(4):
                btp[b, a] = pb[a, b]
        _times_input(btp, g, dt, quu)  # B' P B
        _times_state(btp, g)  # B' P A
        ga[0] = gradient
        _times_input(ga, g, dt, gb)  # B' p
        for a in range(4):
            quu[a, a] += r[a]
            gb[0, a] += r[a] * (nominal[j, a] - targets[j, a // 2, a % 2])
            for b in range(6):
                rhs[a, b] = btp[a, b]
            rhs[a, 6] = gb[0, a]
        _solve4(quu, rhs)
        gains[j] = rhs
        _times_state(ga, g)  # A' p
        pa[:] = p
        _times_state(pa, g)  # P A
        p[:] = pa.T
        _times_state(p, g)  # A' P A (symmetric)
        _weight(q, slots[j], w)
        _error(x[j], slots[j], e)
        for a in range(6):
            gradient[a] = ga[0, a]
            for c in range(4):
                gradient[a] -= btp[c, a] * rhs[c, 6]
            for b in range(6):
                gradient[a] -= w[a, b] * e[b]
                p[a, b] += w[a, b]
                for c in range(4):
                    p[a, b] -= btp[c, a] * rhs[c, b]

    change = 0.0
    here = x0.copy()
    for j in range(steps):
        for a in range(4):
            value = nominal[j, a] - gains[j, a, 6]
            for b in range(6):
                value -= gains[j, a, b] * (here[b] - x[j, b])
            out[j, a] = clip(value, limits[a % 2])
            change = max(change, abs(out[j, a] - nominal[j, a]))
            if not math.isfinite(value):
                return math.nan
        _move(here, out[j], dt, here)
    return change
