"""The paper's error state and its Jacobians as printed, compiled; each erratum is a switch that mends it.

Equation and appendix numbers are the paper's. The error state is z = (x_e, y_e, theta_e, l_e, psi_e).
"""

import math

from agents.kernels.jit import FLAGS, MATRIX_OUT, NOTHING, REAL, STRIDED_VECTOR, VECTOR, VECTOR_OUT, kernel, kernel_for
from agents.kernels.unicycle import wrap
from formation.arrays import FloatArray

OMEGA_XI, CENTRE_VELOCITY, THETA_COLUMN, INPUTS, EQUILIBRIUM = 1, 2, 3, 4, 5
"""Switches that mend erratum 1, 2, 3, 4, 5."""
DRIFT, RELATIVE, ONE_HEADING, STEP_4_STATES, ROLLED_OUT, BEST_RESPONSE = 6, 7, 8, 9, 10, 11
"""Other readings of the printed text: half of erratum 4 (the affine term; inputs counted from the reference's), only
the own heading moves with theta_e, eq. (11) takes the states of step 4 or rolls the bodies forward in place of (5),
and the Riccati recursion of a best response to the received plan in place of (10)."""
SWITCHES = 12


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


@kernel
def _sin_cos(angle: float) -> tuple[float, float]:
    return math.sin(angle), math.cos(angle)


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
        mended: (SWITCHES,) flags.
        a, bi, bu: results (5, 5), (5, 2), (5, 2).
        rate: dz/dt (5,) by eq. (3) with l_r constant.
    """
    dx, dy = own[0] - other[0], own[1] - other[1]
    length, psi = math.hypot(dx, dy), math.atan2(dx, -dy)
    theta = 0.5 * (own[2] + other[2])
    omega_c = 0.5 * (u[1] + w[1])
    (sin_i, cos_i), (sin_u, cos_u) = _sin_cos(psi - own[2]), _sin_cos(psi - other[2])
    st, ct = _sin_cos(theta - psi)
    xi1, xi2 = pv[0] * st - pv[1] * ct, pv[0] * ct + pv[1] * st
    xi1_t, xi2_t = -pv[0] * ct - pv[1] * st, pv[0] * st - pv[1] * ct  # by theta_e
    xi1_p, xi2_p = -xi1_t, -xi2_t  # by psi_e
    turn = u[0] * cos_i - w[0] * cos_u  # l psi'
    slide = u[0] * sin_i - w[0] * sin_u
    # How many times theta_e robot i and its neighbour turn when theta_e changes.
    turns_i = 1.0 if mended[THETA_COLUMN] else 2.0
    turns_u = 0.0 if mended[ONE_HEADING] else turns_i
    spin = 0.0 if mended[OMEGA_XI] else 1.0  # the terms omega_c xi
    turn_t = turns_i * u[0] * cos_i - turns_u * w[0] * cos_u
    slide_t = turns_i * u[0] * sin_i - turns_u * w[0] * sin_u
    (si, ci), (su, cu) = _sin_cos(own[2] - theta), _sin_cos(other[2] - theta)
    if not mended[CENTRE_VELOCITY]:
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
    a[0, 2] = -ref[3] * math.sin(z[2]) + spin * omega_c * xi1_t - (xi1_t * turn - xi1 * slide_t) / length
    a[0, 3] = -xi1 / length**2 * turn
    a[0, 4] = spin * omega_c * xi1_p - (xi1_p * turn + xi1 * slide) / length
    a[1, 2] = ref[3] * math.cos(z[2]) + spin * omega_c * xi2_t - (xi2_t * turn - xi2 * slide_t) / length
    a[1, 3] = -xi2 / length**2 * turn
    a[1, 4] = spin * omega_c * xi2_p - (xi2_p * turn + xi2 * slide) / length
    a[3, 2], a[3, 4] = -turn_t, turn
    a[4, 2] = slide_t / length
    a[4, 3] = -(u[0] * cos_i - w[0] * (cos_u if mended[THETA_COLUMN] else sin_u)) / length**2
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
