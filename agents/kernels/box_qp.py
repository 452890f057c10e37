"""Small quadratic programs within limits, compiled: one stage of a plan whose inputs are bounded.

The projected Newton method of box-DDP (Tassa, Mansard and Todorov 2014, "Control-limited differential dynamic
programming", algorithm 1; after Bertsekas 1982).
"""

import numpy as np

from agents.kernels.jit import kernel
from agents.kernels.linalg import solve_positive
from formation.arrays import FloatArray

HALVINGS = 12
"""Of a step that does not lower the cost."""
STEPS = 30
"""Projected Newton steps of one program; a handful is the rule."""


@kernel
def solve_free(quu: FloatArray, right: FloatArray, free: FloatArray, work: FloatArray) -> None:
    """right <- inverse(quu) right on the inputs that are free (1.0), and zero on those that are held (0.0)."""
    for a in range(len(quu)):
        for b in range(len(quu)):
            work[a, b] = quu[a, b] * free[a] * free[b]
        if free[a] == 0.0:
            work[a, a] = 1.0
            right[a] = 0.0
    solve_positive(work, right)


@kernel
def _stage_value(quu: FloatArray, qu: FloatArray, d: FloatArray) -> float:
    value = 0.0
    for a in range(len(d)):
        value += d[a] * qu[a]
        for b in range(len(d)):
            value += 0.5 * d[a] * quu[a, b] * d[b]
    return value


@kernel
def in_box(
    quu: FloatArray,
    qu: FloatArray,
    low: FloatArray,
    high: FloatArray,
    d: FloatArray,
    free: FloatArray,
    work: FloatArray,
) -> None:
    """d = argmin d' quu d / 2 + qu' d within low <= d <= high (low <= 0 <= high), by projected Newton steps.

    `free` (m,) becomes 0 where d is held by a limit that it would leave, else 1.
    """
    m = len(d)
    newton, trial = np.empty((m, 1)), np.empty(m)
    d[:] = 0.0
    for _ in range(STEPS):
        for a in range(m):
            slope = qu[a]
            for b in range(m):
                slope += quu[a, b] * d[b]
            held = (d[a] <= low[a] and slope > 0.0) or (d[a] >= high[a] and slope < 0.0)
            free[a] = 0.0 if held else 1.0
            newton[a, 0] = -slope
        solve_free(quu, newton, free, work)
        before, share, moved = _stage_value(quu, qu, d), 1.0, 0.0
        for _ in range(HALVINGS):
            moved = 0.0
            for a in range(m):
                trial[a] = min(max(d[a] + share * newton[a, 0], low[a]), high[a])
                moved = max(moved, abs(trial[a] - d[a]))
            if _stage_value(quu, qu, trial) <= before:
                break
            share *= 0.5
        d[:] = trial
        if moved < 1e-13:
            return
