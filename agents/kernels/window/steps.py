"""The steps of the window filter: prediction by odometry, updates by measurements, detection of disturbances."""

import math

import numpy as np

from agents.kernels.drifting import between, wrap_small
from agents.kernels.jit import kernel
from agents.kernels.window.state import DL, DV, DW, THETA, Core, Tuning
from formation.arrays import FloatArray

GATE, GATE_RELATIVE = 20.0, 25.0
"""Squared Mahalanobis distance above which a measurement is rejected."""
PATIENCE = 8
"""Rejections in a row after which one is accepted."""
EWMA_CLIP = 4.0
WALK, WALK_TURN = 0.0003, 0.001
"""Random walks of d_v, d_l [m/s/sqrt(s)] and d_w [rad/s/sqrt(s)]."""
LEVEL, LEVEL_TURN = 0.01, 0.05
ACROSS = 0.001
"""Q across: (0.001 dt)^2 [m/s]."""
SLOWEST = 0.01
"""A stuck robot must not wind up, nor one whose slot stands be without a disturbance [m/s]."""


@kernel
def predict(
    core: Core, h: int, v: float, omega: float, along: float, across: float, turn: float, speed: float, dt: float
) -> None:
    """Block h one tick on.

    Args:
        core: changed.
        h: block.
        v, omega: odometry [m/s, rad/s].
        along, across, turn: standard deviations of its white noise per tick [m/s, m/s, rad/s].
        speed: |v_r| of its slot, for the clips [m/s].
        dt: [s].
    """
    m, p, o = core.mean[h], core.cov, 6 * h
    theta = m[THETA] + 0.5 * dt * (omega + m[DW])
    c, s = math.cos(theta), math.sin(theta)
    forward, lateral = v + m[DV], m[DL]
    dx, dy = dt * (forward * c - lateral * s), dt * (forward * s + lateral * c)
    m[0] += dx
    m[1] += dy
    m[2] += dt * (omega + m[DW])
    cd, sd = dt * c, dt * s
    for a in range(len(p)):
        t, dv, dl = p[o + 2, a], p[o + 3, a], p[o + 4, a]
        p[o, a] += cd * dv - sd * dl - dy * t
        p[o + 1, a] += sd * dv + cd * dl + dx * t
        p[o + 2, a] += dt * p[o + 5, a]
    for a in range(len(p)):
        t, dv, dl = p[a, o + 2], p[a, o + 3], p[a, o + 4]
        p[a, o] += cd * dv - sd * dl - dy * t
        p[a, o + 1] += sd * dv + cd * dl + dx * t
        p[a, o + 2] += dt * p[a, o + 5]
    qa, qc = (dt * along) ** 2, (dt * across) ** 2
    p[o, o] += qa * c * c + qc * s * s
    p[o + 1, o + 1] += qa * s * s + qc * c * c
    p[o, o + 1] += (qa - qc) * c * s
    p[o + 1, o] += (qa - qc) * c * s
    p[o + 2, o + 2] += (dt * turn) ** 2
    p[o + 3, o + 3] += WALK * WALK * dt
    p[o + 4, o + 4] += WALK * WALK * dt
    p[o + 5, o + 5] += WALK_TURN * WALK_TURN * dt
    speed = max(speed, SLOWEST)
    m[DV] = between(m[DV], -1.3 * speed, 1.3 * speed)
    m[DL] = between(m[DL], -0.5 * speed, 0.5 * speed)
    m[DW] = between(m[DW], -0.2, 0.2)


@kernel
def scalar(core: Core, index: int, value: float, var: float) -> None:
    """Update by a measurement of one state; `value` is the innovation."""
    p, flat = core.cov, core.state
    size = len(p)
    scale = 1.0 / (p[index, index] + var)
    shrink = var * scale
    for a in range(size):
        along = p[a, index]
        if a != index and along != 0.0:
            gain = along * scale
            for b in range(size):
                p[a, b] -= gain * p[index, b]
            flat[a] += gain * value
            p[a, index] = along
    flat[index] += (1.0 - shrink) * value
    for a in range(size):
        p[a, index] *= shrink
        p[index, a] = p[a, index]


@kernel
def localise(core: Core, h: int, z: FloatArray, q: Tuning) -> bool:
    """Block h is at z (3,) [m, m, rad]. Returns whether a disturbance was detected."""
    m, p, o = core.mean[h], core.cov, 6 * h
    if q.var_position == 0.0:  # a perfect sensor: the estimate is the measurement, to the last bit
        m[:3] = z
        m[3:] = 0.0
        p[o : o + 6] = 0.0
        p[:, o : o + 6] = 0.0
        return False
    n0, n1, n2 = z[0] - m[0], z[1] - m[1], wrap_small(z[2] - m[2])
    s00, s10, s11 = p[o, o] + q.var_position, p[o + 1, o], p[o + 1, o + 1] + q.var_position
    s20, s21, s22 = p[o + 2, o], p[o + 2, o + 1], p[o + 2, o + 2] + q.var_heading
    l10, l20 = s10 / s00, s20 / s00
    d1 = s11 - l10 * s10
    l21 = (s21 - l20 * s10) / d1
    d2 = s22 - l20 * s20 - l21 * l21 * d1
    e1 = n1 - l10 * n0
    e2 = n2 - l20 * n0 - l21 * e1
    if n0 * n0 / s00 + e1 * e1 / d1 + e2 * e2 / d2 > GATE and core.rejected[h, 0] < PATIENCE:
        core.rejected[h, 0] += 1
        return False
    core.rejected[h, 0] = 0
    c, s = math.cos(m[2]), math.sin(m[2])
    forward = (c * n0 + s * n1) / math.sqrt(c * c * s00 + 2.0 * c * s * s10 + s * s * s11)
    lateral = (c * n1 - s * n0) / math.sqrt(s * s * s00 - 2.0 * c * s * s10 + c * c * s11)
    turn = n2 / math.sqrt(s22)
    scalar(core, o, n0, q.var_position)
    scalar(core, o + 1, z[1] - m[1], q.var_position)
    scalar(core, o + 2, wrap_small(z[2] - m[2]), q.var_heading)
    if not q.detects:
        return False
    found = detect(core, h, 0, forward, h, -1, q)
    found |= detect(core, h, 1, lateral, h, -1, q)
    found |= detect(core, h, 2, turn, h, -1, q)
    return bool(found)


@kernel
def relate(core: Core, h: int, g: int, z: FloatArray, q: Tuning) -> bool:
    """Block h sees block g at z (2,) in its own frame [m]. Returns whether a disturbance was detected."""
    p, size = core.cov, len(core.cov)
    a, b = core.mean[h], core.mean[g]
    c, s = math.cos(a[2]), math.sin(a[2])
    dx, dy = b[0] - a[0], b[1] - a[1]
    hx, hy = c * dx + s * dy, c * dy - s * dx
    n0, n1 = z[0] - hx, z[1] - hy
    oh, og = 6 * h, 6 * g
    # Rows of H: (-c, -s, hy) and (s, -c, -hx) on block h, (c, s) and (-s, c) on block g. First P H'.
    u0, u1 = np.empty(size), np.empty(size)
    for i in range(size):
        x, y, turn = p[i, og] - p[i, oh], p[i, og + 1] - p[i, oh + 1], p[i, oh + 2]
        u0[i] = c * x + s * y + hy * turn
        u1[i] = c * y - s * x - hx * turn
    # Then S = H P H' + R, and from its LDL' factors the innovations where it is diagonal.
    x, y = u0[og] - u0[oh], u0[og + 1] - u0[oh + 1]
    s00, s01 = c * x + s * y + hy * u0[oh + 2] + q.var_relative, c * y - s * x - hx * u0[oh + 2]
    x, y = u1[og] - u1[oh], u1[og + 1] - u1[oh + 1]
    s11 = c * y - s * x - hx * u1[oh + 2] + q.var_relative
    ratio = s01 / s00
    d1 = s11 - ratio * s01
    e1 = n1 - ratio * n0
    if n0 * n0 / s00 + e1 * e1 / d1 > GATE_RELATIVE and core.rejected[h, 1] < PATIENCE:
        core.rejected[h, 1] += 1
        return False
    core.rejected[h, 1] = 0
    for i in range(size):
        u1[i] -= ratio * u0[i]
    for i in range(size):
        k0, k1 = u0[i] / s00, u1[i] / d1
        core.state[i] += k0 * n0 + k1 * e1
        for j in range(size):
            p[i, j] -= k0 * u0[j] + k1 * u1[j]
    if not q.detects:
        return False
    found = detect(core, h, 3, n0 / math.sqrt(s00), h, g, q)
    found |= detect(core, h, 4, e1 / math.sqrt(d1), h, g, q)
    return bool(found)


@kernel
def detect(core: Core, h: int, sensor: int, value: float, first: int, second: int, q: Tuning) -> bool:
    """Take a normalised innovation into its EWMA; where that is too large, forget what is believed of that axis.

    Args:
        core: changed.
        h, sensor: row and column of core.ewma.
        value: the innovation over its standard deviation.
        first, second: blocks whose disturbance may be the cause (second -1: none).
        q: constants.
    """
    e = core.ewma[h]
    e[sensor] += q.gain * (between(value, -EWMA_CLIP, EWMA_CLIP) - e[sensor])
    if abs(e[sensor]) <= q.threshold:
        return False
    axis = sensor % 3
    found = doubt(core, first, axis, q.began)
    if second >= 0:
        found |= doubt(core, second, axis, q.began)
    if found:
        e[sensor] *= 0.5
    return bool(found)


@kernel
def doubt(core: Core, h: int, axis: int, began: float) -> bool:
    """Raise P of block h to the level of a disturbance along axis 0 (forward), 1 (lateral) or 2 (turn)."""
    p, o = core.cov, 6 * h
    d = o + 3 + axis
    level = LEVEL_TURN if axis == 2 else LEVEL
    more = level * level - p[d, d]
    if more <= 0.0:
        return False
    theta = core.mean[h, THETA]
    if axis == 2:
        gx, gy, gt = 0.0, 0.0, began
    elif axis == 0:
        gx, gy, gt = began * math.cos(theta), began * math.sin(theta), 0.0
    else:
        gx, gy, gt = -began * math.sin(theta), began * math.cos(theta), 0.0
    at = (o, o + 1, o + 2, d)
    g = (gx, gy, gt, 1.0)
    for i in range(4):
        for j in range(4):
            p[at[i], at[j]] += more * g[i] * g[j]
    return True
