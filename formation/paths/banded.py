"""Linear systems with few diagonals, in a time that grows with their size and no faster.

No pivots are sought: the systems of splines are diagonally dominant, those of smoothing symmetric and positive
definite. (scipy has the same, but importing it costs a process half a second and 50 MB; it is what the tests compare
with.)
"""

import numpy as np

from formation.arrays import FloatArray


def tridiagonal(lower: FloatArray, diagonal: FloatArray, upper: FloatArray, right: FloatArray) -> FloatArray:
    """The solution (n, d) of a tridiagonal system.

    Args:
        lower: (n,) left of the diagonal; the first is not read.
        diagonal: (n,).
        upper: (n,) right of the diagonal; the last is not read.
        right: (n, d) right-hand sides.
    """
    n = len(diagonal)
    a, b, c = lower.tolist(), diagonal.tolist(), upper.tolist()
    for i in range(1, n):
        a[i] /= b[i - 1]
        b[i] -= a[i] * c[i - 1]
    found = np.empty((n, right.shape[1]))
    for column in range(right.shape[1]):
        x = right[:, column].tolist()
        for i in range(1, n):
            x[i] -= a[i] * x[i - 1]
        x[-1] /= b[-1]
        for i in range(n - 2, -1, -1):
            x[i] = (x[i] - c[i] * x[i + 1]) / b[i]
        found[:, column] = x
    return found


def cyclic_tridiagonal(lower: FloatArray, diagonal: FloatArray, upper: FloatArray, right: FloatArray) -> FloatArray:
    """The solution (n, d) of a tridiagonal system that goes round: n at least 3.

    The two corners are a change of rank one (Sherman and Morrison).

    Args:
        lower: (n,) left of the diagonal; the first stands in the last column.
        diagonal: (n,).
        upper: (n,) right of the diagonal; the last stands in the first column.
        right: (n, d) right-hand sides.
    """
    corner, other = float(upper[-1]), float(lower[0])
    pivot = -float(diagonal[0])
    changed = diagonal.copy()
    changed[0] -= pivot
    changed[-1] -= corner * other / pivot
    spike = np.zeros((len(diagonal), 1))
    spike[0], spike[-1] = pivot, corner
    both = tridiagonal(lower, changed, upper, np.hstack([right, spike]))
    plain, response = both[:, :-1], both[:, -1:]
    share = (plain[:1] + other / pivot * plain[-1:]) / (1.0 + response[:1] + other / pivot * response[-1:])
    return np.asarray(plain - response * share)


def pentadiagonal(diagonal: FloatArray, first: FloatArray, second: FloatArray, right: FloatArray) -> FloatArray:
    """The solution (n, d) of a symmetric, positive definite system with five diagonals.

    Args:
        diagonal: (n,).
        first: (n - 1,) beside it.
        second: (n - 2,) beside that.
        right: (n, d) right-hand sides.
    """
    n = len(diagonal)
    d, e, f = diagonal.tolist(), [*first.tolist(), 0.0], [*second.tolist(), 0.0, 0.0]
    for i in range(n - 1):  # L D L^T, with unit L: e and f become the columns of L
        one, two = e[i] / d[i], f[i] / d[i]
        d[i + 1] -= one * e[i]
        e[i + 1] -= one * f[i]
        if i + 2 < n:
            d[i + 2] -= two * f[i]
        e[i], f[i] = one, two
    found = np.empty((n, right.shape[1]))
    for column in range(right.shape[1]):
        x = right[:, column].tolist()
        for i in range(n - 1):
            x[i + 1] -= e[i] * x[i]
            if i + 2 < n:
                x[i + 2] -= f[i] * x[i]
        for i in range(n - 1, -1, -1):
            x[i] /= d[i]
            if i + 1 < n:
                x[i] -= e[i] * x[i + 1]
            if i + 2 < n:
                x[i] -= f[i] * x[i + 2]
        found[:, column] = x
    return found
