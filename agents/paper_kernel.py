"""The paper's algorithm as printed, compiled; each erratum (THEORY section 3) is a switch that mends it.

Equation and appendix numbers are the paper's. The error state is z = (x_e, y_e, theta_e, l_e, psi_e).
"""

import math

import numpy as np

from agents.compiled import (
    FLAGS,
    MATRIX_OUT,
    NOTHING,
    REAL,
    STRIDED,
    STRIDED_VECTOR,
    VECTOR,
    VECTOR_OUT,
    kernel,
    kernel_for,
)
from agents.kernels import clip, wrap
from formation.arrays import FloatArray


@kernel
def _product(a: FloatArray, b: FloatArray) -> FloatArray:
    out = np.zeros((a.shape[0], b.shape[1]))
    for i in range(a.shape[0]):
        for k in range(a.shape[1]):
            for j in range(b.shape[1]):
                out[i, j] += a[i, k] * b[k, j]
    return out


@kernel
def _solve(matrix: FloatArray, right: FloatArray) -> FloatArray:
    """inverse(matrix) right, by Gaussian elimination with row pivots."""
    m, x = matrix.copy(), right.copy()
    n = len(m)
    for c in range(n):
        best = c
        for i in range(c + 1, n):
            if abs(m[i, c]) > abs(m[best, c]):
                best = i
        for j in range(n):
            m[c, j], m[best, j] = m[best, j], m[c, j]
        for j in range(x.shape[1]):
            x[c, j], x[best, j] = x[best, j], x[c, j]
        for i in range(c + 1, n):
            factor = m[i, c] / m[c, c]
            for j in range(c, n):
                m[i, j] -= factor * m[c, j]
            for j in range(x.shape[1]):
                x[i, j] -= factor * x[c, j]
    for j in range(x.shape[1]):
        for i in range(n - 1, -1, -1):
            for k in range(i + 1, n):
                x[i, j] -= m[i, k] * x[k, j]
            x[i, j] /= m[i, i]
    return x


@kernel_for(NOTHING, VECTOR, VECTOR, STRIDED_VECTOR, REAL, REAL, VECTOR, VECTOR_OUT)
def error_state(
    own: FloatArray, other: FloatArray, ref: FloatArray, distance: float, psi_r: float, pv: FloatArray, z: FloatArray
) -> None:
    """z (5,) of a pair (section 2.1); the compiled twin of formation.measures.error_state.

    Args:
        own, other: poses (3,).
        ref: x_r, y_r, theta_r, v_r, omega_r.
        distance, psi_r: the pattern wanted.
        pv: virtual centre p_v^O (2,).
        z: the result.
    """
    dx, dy = own[0] - other[0], own[1] - other[1]
    psi, theta = math.atan2(dx, -dy), 0.5 * (own[2] + other[2])
    c, s = math.cos(psi), math.sin(psi)
    gx = ref[0] - 0.5 * (own[0] + other[0]) - (c * pv[0] - s * pv[1])
    gy = ref[1] - 0.5 * (own[1] + other[1]) - (s * pv[0] + c * pv[1])
    c, s = math.cos(theta), math.sin(theta)
    z[0], z[1] = c * gx + s * gy, -s * gx + c * gy
    z[2], z[3], z[4] = wrap(ref[2] - theta), distance - math.hypot(dx, dy), wrap(psi_r - psi)


@kernel_for(
    NOTHING,
    VECTOR,
    VECTOR,
    STRIDED_VECTOR,
    STRIDED_VECTOR,
    VECTOR,
    STRIDED_VECTOR,
    VECTOR,
    REAL,
    FLAGS,
    *[MATRIX_OUT] * 3,
    VECTOR_OUT,
)
def linearise(
    own: FloatArray,
    other: FloatArray,
    u: FloatArray,
    w: FloatArray,
    z: FloatArray,
    ref: FloatArray,
    pv: FloatArray,
    dt: float,
    mended: FloatArray,
    a: FloatArray,
    bi: FloatArray,
    bu: FloatArray,
    rate: FloatArray,
) -> None:
    """Jacobians (12) to (14) of eq. (3), and its right-hand side, for one pair at one time.

    Args:
        own, other: poses (3,) of robot i and its neighbour.
        u, w: their inputs (2,).
        z: error state (5,).
        ref: x_r, y_r, theta_r, v_r, omega_r.
        pv: p_v^O (2,).
        dt: Delta_T [s].
        mended: (6,) flags by number of erratum.
        a, bi, bu: results (5, 5), (5, 2), (5, 2).
        rate: dz/dt (5,) by eq. (3) with l_r constant.
    """
    dx, dy = own[0] - other[0], own[1] - other[1]
    length, psi = math.hypot(dx, dy), math.atan2(dx, -dy)
    theta = 0.5 * (own[2] + other[2])
    omega_c = 0.5 * (u[1] + w[1])
    sin_i, cos_i = math.sin(psi - own[2]), math.cos(psi - own[2])
    sin_u, cos_u = math.sin(psi - other[2]), math.cos(psi - other[2])
    st, ct = math.sin(theta - psi), math.cos(theta - psi)
    xi1, xi2 = pv[0] * st - pv[1] * ct, pv[0] * ct + pv[1] * st
    xi1_t, xi2_t = -pv[0] * ct - pv[1] * st, pv[0] * st - pv[1] * ct  # by theta_e
    xi1_p, xi2_p = -xi1_t, -xi2_t  # by psi_e
    turn = u[0] * cos_i - w[0] * cos_u  # l psi'
    slide = u[0] * sin_i - w[0] * sin_u
    twice = 1.0 if mended[3] else 2.0
    spin = 0.0 if mended[1] else 1.0  # the terms omega_c xi
    ci, si = math.cos(own[2] - theta), math.sin(own[2] - theta)
    cu, su = math.cos(other[2] - theta), math.sin(other[2] - theta)
    if not mended[2]:
        ci, si, cu, su = 1.0, 0.0, 1.0, 0.0

    rate[0] = (
        omega_c * (z[1] + spin * xi1) + ref[3] * math.cos(z[2]) - 0.5 * (u[0] * ci + w[0] * cu) - xi1 / length * turn
    )
    rate[1] = (
        -omega_c * (z[0] - spin * xi2) + ref[3] * math.sin(z[2]) - 0.5 * (u[0] * si + w[0] * su) - xi2 / length * turn
    )
    rate[2] = ref[4] - omega_c
    rate[3] = -slide
    rate[4] = ref[4] - turn / length

    a[:] = 0.0
    a[0, 1], a[1, 0] = omega_c, -omega_c
    a[0, 2] = -ref[3] * math.sin(z[2]) + spin * omega_c * xi1_t - (xi1_t * turn - twice * xi1 * slide) / length
    a[0, 3] = -xi1 / length**2 * turn
    a[0, 4] = spin * omega_c * xi1_p - (xi1_p * turn + xi1 * slide) / length
    a[1, 2] = ref[3] * math.cos(z[2]) + spin * omega_c * xi2_t - (xi2_t * turn - twice * xi2 * slide) / length
    a[1, 3] = -xi2 / length**2 * turn
    a[1, 4] = spin * omega_c * xi2_p - (xi2_p * turn + xi2 * slide) / length
    a[3, 2], a[3, 4] = -twice * turn, turn
    a[4, 2] = twice * slide / length
    a[4, 3] = -(u[0] * cos_i - w[0] * (cos_u if mended[3] else sin_u)) / length**2
    a[4, 4] = -slide / length
    bi[:], bu[:] = 0.0, 0.0
    bi[0, 0], bi[0, 1] = -0.5 * ci - cos_i * xi1 / length, 0.5 * (z[1] + spin * xi1)
    bi[1, 0], bi[1, 1] = -0.5 * si - cos_i * xi2 / length, -0.5 * (z[0] - spin * xi2)
    bu[0, 0], bu[0, 1] = -0.5 * cu + cos_u * xi1 / length, bi[0, 1]
    bu[1, 0], bu[1, 1] = -0.5 * su + cos_u * xi2 / length, bi[1, 1]
    bi[2, 1], bu[2, 1] = -0.5, -0.5
    bi[3, 0], bu[3, 0] = -sin_i, sin_u
    bi[4, 0], bu[4, 0] = -cos_i / length, cos_u / length
    a *= dt
    bi *= dt
    bu *= dt
    for i in range(5):
        a[i, i] += 1.0


@kernel
def _euler(pose: FloatArray, u: FloatArray, dt: float) -> FloatArray:
    """Eq. (1)."""
    return np.array(
        [pose[0] + dt * math.cos(pose[2]) * u[0], pose[1] + dt * math.sin(pose[2]) * u[0], pose[2] + dt * u[1]]
    )


@kernel_for(
    NOTHING,
    VECTOR,
    STRIDED,
    VECTOR,
    STRIDED,
    STRIDED,
    STRIDED_VECTOR,
    REAL,
    VECTOR,
    REAL,
    VECTOR,
    VECTOR,
    VECTOR,
    FLAGS,
    MATRIX_OUT,
)
def plan(
    own: FloatArray,
    u: FloatArray,
    other: FloatArray,
    w: FloatArray,
    ref: FloatArray,
    psi_r: FloatArray,
    distance: float,
    pv: FloatArray,
    dt: float,
    q: FloatArray,
    r: FloatArray,
    limits: FloatArray,
    mended: FloatArray,
    out: FloatArray,
) -> None:
    """Steps 3 to 6 of section 3.2.

    Args:
        own, u: pose (3,) and last plan (N, 2) of robot i.
        other, w: the same, as received from the neighbour.
        ref, psi_r: (N + 1, 5) centre and (N + 1,) psi_r over the horizon.
        distance, pv: l_r and p_v^O.
        dt: Delta_T [s].
        q, r: diagonals (5,) and (2,).
        limits: (2,) of |v| and |omega|.
        mended: (6,) flags by number of erratum.
        out: (N, 2) the new plan; NaN if a matrix was singular.
    """
    steps = len(u)
    a, bi, bu = np.empty((steps, 5, 5)), np.empty((steps, 5, 2)), np.empty((steps, 5, 2))
    z, rate, here, drift = np.empty((steps + 1, 5)), np.empty(5), np.empty(5), np.zeros((steps, 5))
    p, o = own.copy(), other.copy()
    for j in range(steps):
        error_state(p, o, ref[j], distance, psi_r[j], pv, z[j])
        linearise(p, o, u[j], w[j], z[j], ref[j], pv, dt, mended, a[j], bi[j], bu[j], rate)
        p, o = _euler(p, u[j], dt), _euler(o, w[j], dt)
        if mended[4]:  # keep the affine term; inputs count from the reference's
            for i in range(5):
                drift[j, i] = z[j, i] + dt * rate[i]
                for m in range(5):
                    drift[j, i] -= a[j, i, m] * z[j, m]
                for m in range(2):
                    drift[j, i] -= bi[j, i, m] * (u[j, m] - ref[j, 3 + m]) + bu[j, i, m] * (w[j, m] - ref[j, 3 + m])

    ks, gs = np.empty((steps + 1, 5, 5)), np.zeros((steps + 1, 5, 1))
    ks[steps] = np.diag(q)
    rinv = np.diag(1.0 / r)
    eye = np.eye(5)
    for j in range(steps - 1, -1, -1):  # eq. (10)
        s = _product(_product(bi[j], rinv), bi[j].T) + _product(_product(bu[j], rinv), bu[j].T)
        w_matrix = eye + _product(s, ks[j + 1])
        at = np.ascontiguousarray(a[j].T)
        ks[j] = _product(at, _product(ks[j + 1], _solve(w_matrix, a[j]))) + np.diag(q)
        c = drift[j].copy().reshape(5, 1) - _product(s, gs[j + 1])
        gs[j] = _product(at, _product(ks[j + 1], _solve(w_matrix, c)) + gs[j + 1])

    here[:] = z[0]
    for j in range(steps):  # eq. (11)
        base = np.zeros(2)
        if mended[4]:
            base[:] = ref[j, 3:5]
        free = _product(a[j], here.copy().reshape(5, 1)) + drift[j].copy().reshape(5, 1)
        k1 = ks[j + 1]
        rb = _product(rinv, np.ascontiguousarray(bi[j].T))
        if mended[5]:  # play the pair's joint optimum
            s = _product(_product(bi[j], rinv), bi[j].T) + _product(_product(bu[j], rinv), bu[j].T)
            after = _solve(eye + _product(s, k1), free - _product(s, gs[j + 1]))
            ui = -_product(rb, _product(k1, after) + gs[j + 1])
        else:  # answer the received plan
            played = free + _product(bu[j], (w[j] - base).reshape(2, 1))
            m = np.eye(2) + _product(rb, _product(k1, bi[j]))
            ui = -_solve(m, _product(rb, _product(k1, played) + gs[j + 1]))
            after = played
        for m in range(2):
            out[j, m] = clip(ui[m, 0] + base[m], limits[m])
        if not mended[5]:
            after = after + _product(bi[j], (out[j] - base).reshape(2, 1))
        here[:] = after[:, 0]
