"""n unicycles planned as one: a compiled Gauss-Newton solver of the joint optimum within the input limits.

The cost is sum_j e_j' W_j e_j / 2 + sum_j (u_j - u_r,j)' R (u_j - u_r,j) / 2 with e = slots - poses (3n,) and any
weights W_j. Each step linearises the exact unicycles along the last plan, goes backwards with a Riccati recursion
whose stages are minimised within the limits (box-DDP: Tassa, Mansard and Todorov 2014), and searches along the
roll-out until the cost falls. Steps are taken until nothing changes any more.
"""

import math

import numpy as np

from agents.kernels.box_qp import HALVINGS, in_box, solve, solve_free
from agents.kernels.jit import MATRIX, MATRIX_OUT, NOTHING, REAL, TABLE, TABLE_OUT, VECTOR, WHOLE, kernel, kernel_for
from agents.kernels.unicycle import clip, derivatives, step, wrap
from formation.arrays import FloatArray


@kernel_for(NOTHING, TABLE, VECTOR, TABLE_OUT)
def ring_weights(slots: FloatArray, q: FloatArray, weights: FloatArray) -> None:
    """W_j of sum_i J_i: every robot's game with its upstream neighbour (agents/kernels/pair_game.py), added up.

    Args:
        slots: (N + 1, n, 3) slot poses; the desired edges are those between them.
        q: (6,) centre, centre, mean heading, radial, tangential, half-difference of headings.
        weights: out, (N + 1, 3n, 3n).
    """
    n = slots.shape[1]
    weights[:] = 0.0
    for j in range(len(slots)):
        w = weights[j]
        for i in range(n):
            other = (i + n - 1) % n
            dx, dy = slots[j, other, 0] - slots[j, i, 0], slots[j, other, 1] - slots[j, i, 1]
            squared = dx * dx + dy * dy
            radial, tangential = q[3] / squared, q[4] / (squared * squared)
            dxx = radial * dx * dx + tangential * dy * dy
            dxy = (radial - tangential) * dx * dy
            dyy = radial * dy * dy + tangential * dx * dx
            for a in range(2):
                for b in range(2):
                    sign = 1.0 if a == b else -1.0
                    row, column = 3 * (i if a == 0 else other), 3 * (i if b == 0 else other)
                    w[row, column] += 0.25 * q[0] + sign * dxx
                    w[row, column + 1] += sign * dxy
                    w[row + 1, column] += sign * dxy
                    w[row + 1, column + 1] += 0.25 * q[1] + sign * dyy
                    w[row + 2, column + 2] += 0.25 * (q[2] + sign * q[5])


@kernel
def _move(x: FloatArray, u: FloatArray, dt: float, out: FloatArray) -> None:
    """All robots (3n,) one interval on under u (2n,)."""
    for a in range(len(u) // 2):
        out[3 * a], out[3 * a + 1], out[3 * a + 2] = step(
            x[3 * a], x[3 * a + 1], x[3 * a + 2], u[2 * a], u[2 * a + 1], dt
        )


@kernel
def _slope(x: FloatArray, slots: FloatArray, w: FloatArray, e: FloatArray, gradient: FloatArray) -> float:
    """Stage cost e' W e / 2; its gradient -W e by x into `gradient` (3n,), e = slots - x into `e` (3n,)."""
    for a in range(len(slots)):
        e[3 * a] = slots[a, 0] - x[3 * a]
        e[3 * a + 1] = slots[a, 1] - x[3 * a + 1]
        e[3 * a + 2] = wrap(slots[a, 2] - x[3 * a + 2])
    cost = 0.0
    for a in range(len(e)):
        gradient[a] = 0.0
        for b in range(len(e)):
            gradient[a] -= w[a, b] * e[b]
        cost -= 0.5 * e[a] * gradient[a]
    return cost


@kernel
def _effort(u: FloatArray, targets: FloatArray, r: FloatArray) -> float:
    cost = 0.0
    for a in range(len(u)):
        gap = u[a] - targets[a // 2, a % 2]
        cost += 0.5 * r[a % 2] * gap * gap
    return cost


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
    x, e, gradient = x0.copy(), np.empty_like(x0), np.empty_like(x0)
    total = 0.0
    for j in range(len(u)):
        total += _slope(x, slots[j], weights[j], e, gradient) + _effort(u[j], targets[j], r)
        _move(x, u[j], dt, x)
    total += _slope(x, slots[len(u)], weights[len(u)], e, gradient)
    return float(total)


@kernel
def _times_input(p: FloatArray, g: FloatArray, dt: float, out: FloatArray) -> None:
    """out (rows, 2n) = p (rows, 3n) B, where g (n, 6) holds `derivatives` of all robots."""
    for a in range(len(p)):
        for i in range(len(g)):
            px, py, pt = p[a, 3 * i], p[a, 3 * i + 1], p[a, 3 * i + 2]
            out[a, 2 * i] = px * g[i, 2] + py * g[i, 3]
            out[a, 2 * i + 1] = px * g[i, 4] + py * g[i, 5] + pt * dt


@kernel
def _times_state(p: FloatArray, g: FloatArray) -> None:
    """p (rows, 3n) <- p A in place: only the columns of the headings change."""
    for a in range(len(p)):
        for i in range(len(g)):
            p[a, 3 * i + 2] += p[a, 3 * i] * g[i, 0] + p[a, 3 * i + 1] * g[i, 1]


@kernel
def _backward(
    x: FloatArray,
    u: FloatArray,
    slots: FloatArray,
    targets: FloatArray,
    weights: FloatArray,
    r: FloatArray,
    dt: float,
    limits: FloatArray,
    gains: FloatArray,
) -> None:
    """Riccati recursion along x (N + 1, 3n), u (N, 2n): gains (N, 2n, 3n + 1) = (K | k), du = K dx + k."""
    s, m = x.shape[1], u.shape[1]
    p, pa, gradient, e = np.empty((s, s)), np.empty((s, s)), np.empty((1, s)), np.empty(s)
    g, pb, qux, quu = np.empty((m // 2, 6)), np.empty((s, m)), np.empty((m, s)), np.empty((m, m))
    qu, work, stage = np.empty((1, m)), np.empty((m, m)), np.empty(s)
    low, high, d, free = np.empty(m), np.empty(m), np.empty(m), np.empty(m)
    p[:] = weights[len(u)]
    _slope(x[len(u)], slots[len(u)], weights[len(u)], e, gradient[0])
    for j in range(len(u) - 1, -1, -1):
        for a in range(m // 2):
            g[a, 0], g[a, 1], g[a, 2], g[a, 3], g[a, 4], g[a, 5] = derivatives(
                x[j, 3 * a + 2], u[j, 2 * a], u[j, 2 * a + 1], dt
            )
        _times_input(p, g, dt, pb)  # P B
        for a in range(s):
            for b in range(m):
                qux[b, a] = pb[a, b]
        _times_input(qux, g, dt, quu)  # B' P B
        _times_state(qux, g)  # B' P A
        _times_input(gradient, g, dt, qu)  # B' p
        inside = True
        for a in range(m):
            quu[a, a] += r[a % 2]
            qu[0, a] += r[a % 2] * (u[j, a] - targets[j, a // 2, a % 2])
            low[a], high[a] = -limits[a % 2] - u[j, a], limits[a % 2] - u[j, a]
        work[:] = quu
        k = gains[j]
        for a in range(m):
            for b in range(s):
                k[a, b] = -qux[a, b]
            k[a, s] = -qu[0, a]
        solve(work, k)
        for a in range(m):
            inside = inside and low[a] <= k[a, s] <= high[a]
        if not inside:
            in_box(quu, qu[0], low, high, d, free, work)
            for a in range(m):
                for b in range(s):
                    k[a, b] = -qux[a, b]
            solve_free(quu, k, free, work)
            k[:, s] = d
        pa[:] = p
        _times_state(pa, g)  # P A
        p[:] = pa.T
        _times_state(p, g)  # A' P A
        _times_state(gradient, g)  # A' p
        _slope(x[j], slots[j], weights[j], e, stage)
        for a in range(s):
            gradient[0, a] += stage[a]
            for c in range(m):
                gradient[0, a] += qux[c, a] * k[c, s]
            for b in range(s):
                p[a, b] += weights[j, a, b]
                for c in range(m):
                    p[a, b] += qux[c, a] * k[c, b]


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
        r: (2,) of v and omega, the same for every robot.
        dt: Delta_T [s].
        limits: (2,) of |v| and |omega|.
        steps: at most so many Gauss-Newton steps.
        tolerance: the largest change of an input at which it has converged.
        out: (N, 2n).

    Returns:
        The largest change of an input in the last step; NaN if there is no finite plan.
    """
    horizon, m = nominal.shape
    x, trial = np.empty((horizon + 1, len(x0))), np.empty((horizon + 1, len(x0)))
    u = np.empty_like(out)
    gains = np.empty((horizon, m, len(x0) + 1))
    x[0] = x0
    trial[0] = x0
    for j in range(horizon):
        for a in range(m):
            out[j, a] = clip(nominal[j, a], limits[a % 2])
        _move(x[j], out[j], dt, x[j + 1])
    best = cost(x0, out, slots, targets, weights, r, dt)
    change = 0.0 if math.isfinite(best) else math.nan
    for _ in range(steps):
        _backward(x, out, slots, targets, weights, r, dt, limits, gains)
        share, accepted = 1.0, False
        for _ in range(HALVINGS):
            change = 0.0
            for j in range(horizon):
                for a in range(m):
                    value = out[j, a] + share * gains[j, a, len(x0)]
                    for b in range(len(x0)):
                        value += gains[j, a, b] * (trial[j, b] - x[j, b])
                    if not math.isfinite(value):
                        return math.nan
                    u[j, a] = clip(value, limits[a % 2])
                    change = max(change, abs(u[j, a] - out[j, a]))
                _move(trial[j], u[j], dt, trial[j + 1])
            now = cost(x0, u, slots, targets, weights, r, dt)
            accepted = now <= best
            if accepted or change <= tolerance:
                break
            share *= 0.5
        if not accepted:
            return change
        best = now
        out[:] = u
        x[:] = trial
        if change <= tolerance:
            break
    return change
