"""The paper's game between two robots, compiled: steps 3 to 6 of section 3.2, with eqs. (10) and (11).

As printed; each erratum is a switch that mends it (agents/kernels/paper_errors.py names them).
"""

import math

import numpy as np

from agents.kernels.jit import FLAGS, MATRIX_OUT, NOTHING, REAL, STRIDED, STRIDED_VECTOR, VECTOR, kernel, kernel_for
from agents.kernels.linalg import solve_positive, times, transposed_times
from agents.kernels.paper_errors import (
    BEST_RESPONSE,
    DRIFT,
    EQUILIBRIUM,
    INPUTS,
    RELATIVE,
    ROLLED_OUT,
    STEP_4_STATES,
    error_state,
    linearise,
)
from agents.kernels.unicycle import clip
from formation.arrays import FloatArray


@kernel
def _euler(pose: FloatArray, u: FloatArray, dt: float) -> None:
    """Eq. (1), in place."""
    pose[0] += dt * math.cos(pose[2]) * u[0]
    pose[1] += dt * math.sin(pose[2]) * u[0]
    pose[2] += dt * u[1]


@kernel
def _less_play(b: FloatArray, r: FloatArray, g: FloatArray, players: int, out: FloatArray) -> None:
    """Out -= S g, with S = B R^-1 B^T of as many players."""
    for m in range(2 * players):
        total = 0.0
        for i in range(5):
            total += b[i, m] * g[i]
        total /= r[m % 2]
        for i in range(5):
            out[i] -= b[i, m] * total


@kernel
def _backward(
    a: FloatArray,
    b: FloatArray,
    affine: FloatArray,
    q: FloatArray,
    r: FloatArray,
    players: int,
    ks: FloatArray,
    ms: FloatArray,
    gs: FloatArray,
) -> None:
    """Eq. (10), with W inverted by Woodbury's identity: K W^-1 = M = K - K B (R + B^T K B)^-1 B^T K, symmetric.

    With an affine term the costate is K z + g. The inputs of as many players count: both, or robot i alone.
    """
    size = 2 * players
    kb, at_m, inner = np.empty((5, size)), np.empty((5, 5)), np.empty((size, size))
    gain, c = np.empty((size, 5)), np.empty(5)
    ks[-1] = np.diag(q)
    for j in range(len(a) - 1, -1, -1):
        times(ks[j + 1], b[j, :, :size], kb)
        transposed_times(b[j, :, :size], kb, inner)
        for m in range(size):
            inner[m, m] += r[m % 2]
            for i in range(5):
                gain[m, i] = kb[i, m]
        solve_positive(inner, gain)
        times(kb, gain, ms[j])
        for i in range(5):
            c[i] = affine[j, i]
            for n in range(5):
                ms[j, i, n] = ks[j + 1, i, n] - ms[j, i, n]
        _less_play(b[j], r, gs[j + 1], players, c)
        transposed_times(a[j], ms[j], at_m)
        times(at_m, a[j], ks[j])
        for i in range(5):
            ks[j, i, i] += q[i]
            gs[j, i] = 0.0
            for n in range(5):
                gs[j, i] += at_m[i, n] * c[n] + a[j, n, i] * gs[j + 1, n]


@kernel
def _equilibrium(b: FloatArray, r: FloatArray, m: FloatArray, g: FloatArray, after: FloatArray, u: FloatArray) -> None:
    """Eqs. (8) and (9): what both play, u (4,), from the state `after` that no input would lead to."""
    costate = np.empty(5)
    _less_play(b, r, g, 2, after)
    for i in range(5):
        costate[i] = g[i]
        for n in range(5):
            costate[i] += m[i, n] * after[n]
    for c in range(4):
        u[c] = 0.0
        for i in range(5):
            u[c] -= b[i, c] * costate[i] / r[c % 2]


@kernel
def _answer(b: FloatArray, r: FloatArray, k: FloatArray, g: FloatArray, after: FloatArray, u: FloatArray) -> None:
    """Eq. (11): what robot i plays, u[:2], where the neighbour's input is part of `after`."""
    kb, inner, right = np.empty((5, 2)), np.empty((2, 2)), np.zeros((2, 1))
    times(k, b[:, :2], kb)
    transposed_times(b[:, :2], kb, inner)
    for c in range(2):
        inner[c, c] += r[c]
        for i in range(5):
            right[c, 0] -= kb[i, c] * after[i] + b[i, c] * g[i]
    solve_positive(inner, right)
    u[0], u[1] = right[0, 0], right[1, 0]


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
        mended: (SWITCHES,) flags.
        out: (N, 2) the new plan; NaN if a matrix was singular.
    """
    steps = len(u)
    drifts, relative = mended[INPUTS] or mended[DRIFT], mended[INPUTS] or mended[RELATIVE]
    a, b = np.empty((steps, 5, 5)), np.empty((steps, 5, 4))  # B_i and B_-i side by side
    bi, bu = np.empty((5, 2)), np.empty((5, 2))
    z, rate, affine = np.empty((steps + 1, 5)), np.empty(5), np.zeros((steps, 5))
    p, o = own.copy(), other.copy()
    for j in range(steps):
        error_state(p, o, ref[j], distance, psi_r[j], pv, z[j])
        linearise(p, o, u[j], w[j], z[j], ref[j], pv, dt, mended, a[j], bi, bu, rate)
        b[j, :, :2], b[j, :, 2:] = bi, bu
        _euler(p, u[j], dt)
        _euler(o, w[j], dt)
        for i in range(5):
            if drifts:
                affine[j, i] = z[j, i] + dt * rate[i]
                for m in range(5):
                    affine[j, i] -= a[j, i, m] * z[j, m]
                for m in range(2):
                    affine[j, i] -= bi[i, m] * u[j, m] + bu[i, m] * w[j, m]
            for m in range(2):
                if relative:
                    affine[j, i] += (bi[i, m] + bu[i, m]) * ref[j, 3 + m]
                if mended[BEST_RESPONSE]:
                    affine[j, i] += bu[i, m] * (w[j, m] - (ref[j, 3 + m] if relative else 0.0))
    ks, ms, gs = np.empty((steps + 1, 5, 5)), np.empty((steps, 5, 5)), np.zeros((steps + 1, 5))
    _backward(a, b, affine, q, r, 1 if mended[BEST_RESPONSE] else 2, ks, ms, gs)
    p[:], o[:] = own, other
    here, after, base, both = z[0].copy(), np.empty(5), np.zeros(2), np.zeros(4)
    for j in range(steps):
        if relative:
            base[:] = ref[j, 3:5]
        if mended[STEP_4_STATES]:
            here[:] = z[j]
        for i in range(5):
            after[i] = affine[j, i]
            for n in range(5):
                after[i] += a[j, i, n] * here[n]
        here[:] = after
        if mended[EQUILIBRIUM]:
            _equilibrium(b[j], r, ms[j], gs[j + 1], after, both)
        else:
            if not mended[BEST_RESPONSE]:  # there the received input is part of the affine term
                both[2], both[3] = w[j, 0] - base[0], w[j, 1] - base[1]
                for i in range(5):
                    after[i] += b[j, i, 2] * both[2] + b[j, i, 3] * both[3]
            _answer(b[j], r, ks[j + 1], gs[j + 1], after, both)
        for c in range(2):
            out[j, c] = clip(both[c] + base[c], limits[c])
            if not mended[EQUILIBRIUM]:
                both[c] = out[j, c] - base[c]
        for i in range(5):  # eq. (5)
            for c in range(4):
                here[i] += b[j, i, c] * both[c]
        if mended[ROLLED_OUT]:
            _euler(p, out[j], dt)
            _euler(o, w[j], dt)
            error_state(p, o, ref[j + 1], distance, psi_r[j + 1], pv, here)
