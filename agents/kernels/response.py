"""The best response along the edges: one Gauss-Newton step over (x, y, theta, v, omega) and two inputs.

docs/theory.md, section 14.

The inputs c are body velocities that the wheels approach with time constant tau: v+ = c + (v - c) E, and the mean over
an interval is c + (v - c) m, with E = exp(-dt/tau) and m = (tau/dt)(1 - E). Without lag E = m = 0.
"""

import math
from typing import NamedTuple

from agents.kernels.drifting import between, wrap_small
from agents.kernels.jit import MATRIX, MATRIX_OUT, REAL, TABLE_OUT, VECTOR, VECTOR_OUT, kernel_for, named
from agents.kernels.unicycle import derivatives, step
from formation.arrays import FloatArray


class Lag(NamedTuple):
    """The wheels over one prediction interval."""

    keep: float
    """E, share of the old speed at the interval's end."""
    blend: float
    """m, share of the old speed in the interval's mean."""


class Stage(NamedTuple):
    """Costs of one solve; lengths in metres, so weights are divided by spacing^2."""

    place: float
    """S_f on |slot - pose|^2 / 2 [1/m2]."""
    edge: FloatArray
    """(Q,) f_q s on the error along the edge to neighbour q, squared, / 2 [1/m2]."""
    heading: float
    """On the heading error, squared, / 2."""
    inputs: FloatArray
    """(2,) R of v [s2/m2] and omega."""
    limits: FloatArray
    """(2,) of |v| and |omega|."""
    room: float
    """On how much nearer than its distance a body is, squared, / 2 [1/m2]."""


class Targets(NamedTuple):
    """What is to be followed over the horizon."""

    slots: FloatArray
    """(N + 1, 3) own slot, its heading turned by the drift [m, m, rad]."""
    inputs: FloatArray
    """(N, 2) own slot's [m/s, rad/s]."""
    direction: FloatArray
    """(Q, N + 1, 2) unit vectors from the own slot to that of neighbour q."""
    error: FloatArray
    """(Q, N + 1) neighbour's error (slot - pose) along that direction [m]."""
    drift: FloatArray
    """(2,) own, world frame [m/s]."""
    bodies: FloatArray
    """(B, M + 1, 3) where bodies near by will be over the first M intervals, and the distance to keep from them [m]."""


LAG = named(Lag, REAL, REAL)
STAGE = named(Stage, REAL, VECTOR_OUT, REAL, VECTOR_OUT, VECTOR_OUT, REAL)
TARGETS = named(Targets, MATRIX_OUT, MATRIX_OUT, TABLE_OUT, MATRIX_OUT, VECTOR_OUT, TABLE_OUT)


def lag_of(tau: float, dt: float) -> Lag:
    """The wheels' time constant [s] over an interval [s]."""
    if tau < 1e-6:
        return Lag(0.0, 0.0)
    keep = math.exp(-dt / tau)
    return Lag(keep, tau / dt * (1.0 - keep))


@kernel_for(REAL, VECTOR, MATRIX, TARGETS, STAGE, LAG, REAL, MATRIX_OUT, MATRIX_OUT, MATRIX_OUT)
def respond(  # noqa: PLR0915  one recursion, written out: a third of the time of one over matrices
    start: FloatArray,
    nominal: FloatArray,
    targets: Targets,
    stage: Stage,
    lag: Lag,
    dt: float,
    work: FloatArray,
    out: FloatArray,
    velocities: FloatArray,
) -> float:
    """One Gauss-Newton step from `nominal`.

    Args:
        start: (5,) pose and body velocity at the plan's stamp.
        nominal: (N, 2) inputs to linearise along.
        targets, stage, lag: see there.
        dt: Delta_T [s].
        work: (N + 1, 24) scratch.
        out: (N, 2), the inputs c.
        velocities: (N, 2), the mean body velocities that they lead to.

    Returns:
        The largest change of an input against `nominal`; NaN if the step failed.
    """
    steps, edges = len(nominal), len(stage.edge)
    bodies, foreseen = len(targets.bodies), targets.bodies.shape[1]
    keep, m = lag.keep, lag.blend
    b, e = 1.0 - m, 1.0 - keep
    bx, by = targets.drift[0] * dt, targets.drift[1] * dt
    x, y, theta, v, w = start[0], start[1], start[2], start[3], start[4]
    for j in range(steps):
        row = work[j]
        row[0], row[1], row[2], row[3], row[4] = x, y, theta, v, w
        cv, cw = nominal[j, 0], nominal[j, 1]
        mv, mw = b * cv + m * v, b * cw + m * w
        row[5], row[6], row[7], row[8], row[9], row[10] = derivatives(theta, mv, mw, dt)
        x, y, theta = step(x, y, theta, mv, mw, dt)
        x, y = x + bx, y + by
        v, w = e * cv + keep * v, e * cw + keep * w
    row = work[steps]
    row[0], row[1], row[2] = x, y, theta

    p00 = p01 = p02 = p11 = p12 = p22 = 0.0
    q00 = q01 = q10 = q11 = q20 = q21 = v00 = v01 = v11 = 0.0
    g0 = g1 = g2 = g3 = g4 = 0.0
    rv, rw = stage.inputs[0], stage.inputs[1]
    for j in range(steps - 1, -1, -1):
        # The stage of j + 1.
        slot, row = targets.slots[j + 1], work[j + 1]
        ex, ey, et = slot[0] - row[0], slot[1] - row[1], wrap_small(slot[2] - row[2])
        p00 += stage.place
        p11 += stage.place
        p22 += stage.heading
        g0 -= stage.place * ex
        g1 -= stage.place * ey
        g2 -= stage.heading * et
        for q in range(edges):
            weight = stage.edge[q]
            if weight > 0.0:
                dx, dy = targets.direction[q, j + 1, 0], targets.direction[q, j + 1, 1]
                p00 += weight * dx * dx
                p01 += weight * dx * dy
                p11 += weight * dy * dy
                pull = weight * (dx * ex + dy * ey - targets.error[q, j + 1])
                g0 -= pull * dx
                g1 -= pull * dy
        for q in range(bodies if j + 1 < foreseen else 0):
            body = targets.bodies[q, j + 1]
            dx, dy = row[0] - body[0], row[1] - body[1]
            if dx * dx + dy * dy < body[2] * body[2]:
                d = max(math.hypot(dx, dy), 1e-6)
                dx, dy = dx / d, dy / d
                p00 += stage.room * dx * dx
                p01 += stage.room * dx * dy
                p11 += stage.room * dy * dy
                push = stage.room * (body[2] - d)
                g0 -= push * dx
                g1 -= push * dy
        row = work[j]
        gx, gy, a, c, f, d = row[5], row[6], row[7], row[8], row[9], row[10]
        m00, m01 = p00 * a + p01 * c, p00 * f + p01 * d + p02 * dt
        m10, m11 = p01 * a + p11 * c, p01 * f + p11 * d + p12 * dt
        m20, m21 = p02 * a + p12 * c, p02 * f + p12 * d + p22 * dt
        gg00, gg01, gg11 = a * m00 + c * m10, a * m01 + c * m11, f * m01 + d * m11 + dt * m21
        h00, h01 = a * q00 + c * q10, a * q01 + c * q11
        h10, h11 = f * q00 + d * q10 + dt * q20, f * q01 + d * q11 + dt * q21
        gu, gw = a * g0 + c * g1, f * g0 + d * g1 + dt * g2
        uu00 = b * b * gg00 + 2.0 * b * e * h00 + e * e * v00 + rv
        uu01 = b * b * gg01 + b * e * (h01 + h10) + e * e * v01
        uu11 = b * b * gg11 + 2.0 * b * e * h11 + e * e * v11 + rw
        l00, l01 = b * m00 + e * q00, b * m01 + e * q01
        l10, l11 = b * m10 + e * q10, b * m11 + e * q11
        l20, l21 = b * m20 + e * q20, b * m21 + e * q21
        u02, u12 = l00 * gx + l10 * gy + l20, l01 * gx + l11 * gy + l21
        u03 = b * m * gg00 + (b * keep + e * m) * h00 + e * keep * v00
        u04 = b * m * gg01 + b * keep * h01 + e * m * h10 + e * keep * v01
        u13 = b * m * gg01 + b * keep * h10 + e * m * h01 + e * keep * v01
        u14 = b * m * gg11 + (b * keep + e * m) * h11 + e * keep * v11
        u05 = b * gu + e * g3 + rv * (nominal[j, 0] - targets.inputs[j, 0])
        u15 = b * gw + e * g4 + rw * (nominal[j, 1] - targets.inputs[j, 1])
        det = 1.0 / (uu00 * uu11 - uu01 * uu01)
        i00, i01, i11 = uu11 * det, -uu01 * det, uu00 * det
        k00, k10 = i00 * l00 + i01 * l01, i01 * l00 + i11 * l01
        k01, k11 = i00 * l10 + i01 * l11, i01 * l10 + i11 * l11
        k02, k12 = i00 * u02 + i01 * u12, i01 * u02 + i11 * u12
        k03, k13 = i00 * u03 + i01 * u13, i01 * u03 + i11 * u13
        k04, k14 = i00 * u04 + i01 * u14, i01 * u04 + i11 * u14
        k05, k15 = i00 * u05 + i01 * u15, i01 * u05 + i11 * u15
        row[11], row[12], row[13], row[14], row[15], row[16] = k00, k01, k02, k03, k04, k05
        row[17], row[18], row[19], row[20], row[21], row[22] = k10, k11, k12, k13, k14, k15
        # P <- Q_xx - Q_ux' K, gradient likewise. A' P: only the heading's row and column change.
        t02, t12 = p00 * gx + p01 * gy + p02, p01 * gx + p11 * gy + p12
        t22 = gx * t02 + gy * t12 + p02 * gx + p12 * gy + p22
        n00, n01 = m * m00 + keep * q00, m * m01 + keep * q01
        n10, n11 = m * m10 + keep * q10, m * m11 + keep * q11
        n20, n21 = m * m20 + keep * q20, m * m21 + keep * q21
        n20, n21 = gx * n00 + gy * n10 + n20, gx * n01 + gy * n11 + n21
        p00, p01 = p00 - l00 * k00 - l01 * k10, p01 - l00 * k01 - l01 * k11
        p11 = p11 - l10 * k01 - l11 * k11
        p02, p12 = t02 - l00 * k02 - l01 * k12, t12 - l10 * k02 - l11 * k12
        p22 = t22 - u02 * k02 - u12 * k12
        q00, q01 = n00 - l00 * k03 - l01 * k13, n01 - l00 * k04 - l01 * k14
        q10, q11 = n10 - l10 * k03 - l11 * k13, n11 - l10 * k04 - l11 * k14
        q20, q21 = n20 - u02 * k03 - u12 * k13, n21 - u02 * k04 - u12 * k14
        v00 = m * m * gg00 + 2.0 * m * keep * h00 + keep * keep * v00 - u03 * k03 - u13 * k13
        v01 = m * m * gg01 + m * keep * (h01 + h10) + keep * keep * v01 - u03 * k04 - u13 * k14
        v11 = m * m * gg11 + 2.0 * m * keep * h11 + keep * keep * v11 - u04 * k04 - u14 * k14
        g2 = gx * g0 + gy * g1 + g2 - u02 * k05 - u12 * k15
        g0, g1 = g0 - l00 * k05 - l01 * k15, g1 - l10 * k05 - l11 * k15
        g3, g4 = m * gu + keep * g3 - u03 * k05 - u13 * k15, m * gw + keep * g4 - u04 * k05 - u14 * k15

    change = 0.0
    x, y, theta, v, w = start[0], start[1], start[2], start[3], start[4]
    for j in range(steps):
        r = work[j]
        dx, dy, dt_, dv, dw = x - r[0], y - r[1], theta - r[2], v - r[3], w - r[4]
        cv = nominal[j, 0] - r[16] - r[11] * dx - r[12] * dy - r[13] * dt_ - r[14] * dv - r[15] * dw
        cw = nominal[j, 1] - r[22] - r[17] * dx - r[18] * dy - r[19] * dt_ - r[20] * dv - r[21] * dw
        if not (math.isfinite(cv) and math.isfinite(cw)):
            return math.nan
        cv, cw = between(cv, -stage.limits[0], stage.limits[0]), between(cw, -stage.limits[1], stage.limits[1])
        change = max(change, abs(cv - nominal[j, 0]), abs(cw - nominal[j, 1]))
        out[j, 0], out[j, 1] = cv, cw
        mv, mw = b * cv + m * v, b * cw + m * w
        velocities[j, 0], velocities[j, 1] = mv, mw
        x, y, theta = step(x, y, theta, mv, mw, dt)
        x, y = x + bx, y + by
        v, w = e * cv + keep * v, e * cw + keep * w
    return change
