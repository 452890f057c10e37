"""Gauss-Newton on n unicycles that are planned together: linear dynamics, quadratic costs, a Riccati recursion.

The cost is sum_j e_j' W_j e_j / 2 + sum_j (u_j - u_r,j)' R (u_j - u_r,j) / 2 with e = slots - poses (3n,) and any
weights W_j. A step linearises the exact unicycles along the last plan, goes backwards with a Riccati recursion and
rolls out forwards. `optimise` minimises every stage of the recursion within the limits (box-DDP: Tassa, Mansard and
Todorov 2014) and searches along the roll-out until the cost falls; agents/kernels/pair_cost.py takes one plain step.
"""

import math

import numpy as np

from agents.kernels.box_qp import HALVINGS, in_box, solve_free
from agents.kernels.jit import MATRIX, MATRIX_OUT, REAL, TABLE, VECTOR, WHOLE, inlined, kernel, kernel_for
from agents.kernels.linalg import solve_positive
from agents.kernels.unicycle import clip, linearise, move, times_input, times_state, wrap
from formation.arrays import FloatArray


@kernel
def _error(x: FloatArray, slots: FloatArray, e: FloatArray) -> None:
    """e (3n,) = slots (n, 3) - x (3n,), headings wrapped."""
    for i in range(len(slots)):
        e[3 * i] = slots[i, 0] - x[3 * i]
        e[3 * i + 1] = slots[i, 1] - x[3 * i + 1]
        e[3 * i + 2] = wrap(slots[i, 2] - x[3 * i + 2])


@kernel
def _half_square(e: FloatArray, w: FloatArray) -> float:
    total = 0.0
    for a in range(len(e)):
        for b in range(len(e)):
            total += e[a] * w[a, b] * e[b]
    return 0.5 * total


@kernel_for(REAL, VECTOR, MATRIX, TABLE, TABLE, TABLE, VECTOR, REAL)
def cost(
    x0: FloatArray,
    u: FloatArray,
    slots: FloatArray,
    targets: FloatArray,
    weights: FloatArray,
    r: FloatArray,
    dt: float,
) -> float:
    """What playing u (N, 2n) from x0 (3n,) costs. Arguments as of `optimise`."""
    x, e = x0.copy(), np.empty_like(x0)
    total = 0.0
    for j in range(len(u) + 1):
        _error(x, slots[j], e)
        total += _half_square(e, weights[j])
        if j < len(u):
            for a in range(u.shape[1]):
                gap = u[j, a] - targets[j, a // 2, a % 2]
                total += 0.5 * r[a] * gap * gap
            move(x, u[j], dt, x)
    return float(total)


@inlined
def backward(
    x: FloatArray,
    u: FloatArray,
    slots: FloatArray,
    targets: FloatArray,
    weights: FloatArray,
    r: FloatArray,
    dt: float,
    limits: FloatArray,
    boxed: bool,
    n: int,
    gains: FloatArray,
) -> None:
    """Riccati recursion along x (N + 1, 3n), u (N, 2n): gains (N, 2n, 3n + 1) = (K | k), du = K dx + k.

    Stages are minimised within the limits if `boxed`. It becomes a part of its caller: where that calls it with a
    constant n, the compiler unrolls its loops.
    """
    s, m = 3 * n, 2 * n
    p, pa, gradient, e = np.empty((s, s)), np.empty((s, s)), np.empty((1, s)), np.empty(s)
    g, pb, qux, quu = np.empty((n, 6)), np.empty((s, m)), np.empty((m, s)), np.empty((m, m))
    qu, work, box = np.empty((1, m)), np.empty((m, m)), np.empty((4, m))
    p[:] = weights[len(u)]
    _error(x[len(u)], slots[len(u)], e)
    for a in range(s):
        gradient[0, a] = 0.0
        for b in range(s):
            gradient[0, a] -= p[a, b] * e[b]
    for j in range(len(u) - 1, -1, -1):
        linearise(x[j], u[j], dt, g)
        times_input(p, g, dt, pb)  # P B
        for a in range(s):
            for b in range(m):
                qux[b, a] = pb[a, b]
        times_input(qux, g, dt, quu)  # B' P B
        times_state(qux, g)  # B' P A
        times_input(gradient, g, dt, qu)  # B' p
        k = gains[j]
        for a in range(m):
            quu[a, a] += r[a]
            qu[0, a] += r[a] * (u[j, a] - targets[j, a // 2, a % 2])
            for b in range(s):
                k[a, b] = -qux[a, b]
            k[a, s] = -qu[0, a]
        for a in range(m):
            for b in range(m):
                work[a, b] = quu[a, b]
        solve_positive(work, k)
        if boxed:
            low, high, d, free = box[0], box[1], box[2], box[3]
            inside = True
            for a in range(m):
                low[a], high[a] = -limits[a % 2] - u[j, a], limits[a % 2] - u[j, a]
                inside = inside and low[a] <= k[a, s] <= high[a]
            if not inside:
                in_box(quu, qu[0], low, high, d, free, work)
                for a in range(m):
                    for b in range(s):
                        k[a, b] = -qux[a, b]
                solve_free(quu, k, free, work)
                k[:, s] = d
        times_state(gradient, g)  # A' p
        pa[:] = p
        times_state(pa, g)  # P A
        p[:] = pa.T
        times_state(p, g)  # A' P A
        _error(x[j], slots[j], e)
        for a in range(s):
            for c in range(m):
                gradient[0, a] += qux[c, a] * k[c, s]
            for b in range(s):
                gradient[0, a] -= weights[j, a, b] * e[b]
                p[a, b] += weights[j, a, b]
                for c in range(m):
                    p[a, b] += qux[c, a] * k[c, b]


@inlined
def forward(
    x: FloatArray,
    u: FloatArray,
    gains: FloatArray,
    share: float,
    dt: float,
    limits: FloatArray,
    n: int,
    rolled: FloatArray,
    out: FloatArray,
) -> float:
    """Roll-out with a share of the gains, within the limits: inputs out (N, 2n) and states rolled (N + 1, 3n).

    Returns:
        The largest change of an input against u; NaN if an input is not finite.
    """
    change, finite = 0.0, True
    for j in range(len(u)):
        for a in range(2 * n):
            value = u[j, a] + share * gains[j, a, 3 * n]
            for b in range(3 * n):
                value += gains[j, a, b] * (rolled[j, b] - x[j, b])
            out[j, a] = clip(value, limits[a % 2])
            change = max(change, abs(out[j, a] - u[j, a]))
            finite = finite and math.isfinite(value)
        move(rolled[j], out[j], dt, rolled[j + 1])
    return change if finite else math.nan


@kernel_for(REAL, VECTOR, MATRIX, TABLE, TABLE, TABLE, VECTOR, REAL, VECTOR, WHOLE, REAL, MATRIX_OUT)
def optimise(
    x0: FloatArray,
    nominal: FloatArray,
    slots: FloatArray,
    targets: FloatArray,
    weights: FloatArray,
    r: FloatArray,
    dt: float,
    limits: FloatArray,
    steps: int,
    tolerance: float,
    out: FloatArray,
) -> float:
    """The joint optimum near `nominal`.

    Args:
        x0: (3n,) poses of all robots.
        nominal: (N, 2n) inputs to begin with; what is beyond the limits is cut off.
        slots, targets: (N + 1, n, 3) slot poses and (N, n, 2) slot inputs.
        weights: (N + 1, 3n, 3n), symmetric and positive semidefinite.
        r: (2n,) of v and omega of every robot.
        dt: Delta_T [s].
        limits: (2,) of |v| and |omega|.
        steps: at most so many Gauss-Newton steps.
        tolerance: the largest change of an input at which it has converged.
        out: (N, 2n).

    Returns:
        The largest change of an input in the last step; NaN if there is no finite plan.
    """
    horizon, m = nominal.shape
    x, rolled = np.empty((horizon + 1, len(x0))), np.empty((horizon + 1, len(x0)))
    u = np.empty_like(out)
    gains = np.empty((horizon, m, len(x0) + 1))
    x[0] = x0
    rolled[0] = x0
    for j in range(horizon):
        for a in range(m):
            out[j, a] = clip(nominal[j, a], limits[a % 2])
        move(x[j], out[j], dt, x[j + 1])
    best = cost(x0, out, slots, targets, weights, r, dt)
    change = 0.0 if math.isfinite(best) else math.nan
    for _ in range(steps):
        backward(x, out, slots, targets, weights, r, dt, limits, True, m // 2, gains)
        share, accepted = 1.0, False
        for _ in range(HALVINGS):
            change = forward(x, out, gains, share, dt, limits, m // 2, rolled, u)
            if not math.isfinite(change):
                return math.nan
            now = cost(x0, u, slots, targets, weights, r, dt)
            accepted = now <= best
            if accepted or change <= tolerance:
                break
            share *= 0.5
        if not accepted:
            return change
        best = now
        out[:] = u
        x[:] = rolled
        if change <= tolerance:
            break
    return change
