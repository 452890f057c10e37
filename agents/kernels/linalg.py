"""Compiled products and solves of small matrices, into arrays that the caller keeps: nothing is allocated."""

import math

from agents.kernels.jit import inlined, kernel
from formation.arrays import FloatArray


@kernel
def times(a: FloatArray, b: FloatArray, out: FloatArray) -> None:
    """Out = a b."""
    for i in range(a.shape[0]):
        for j in range(b.shape[1]):
            total = 0.0
            for k in range(a.shape[1]):
                total += a[i, k] * b[k, j]
            out[i, j] = total


@kernel
def transposed_times(a: FloatArray, b: FloatArray, out: FloatArray) -> None:
    """Out = a^T b."""
    for i in range(a.shape[1]):
        for j in range(b.shape[1]):
            total = 0.0
            for k in range(a.shape[0]):
                total += a[k, i] * b[k, j]
            out[i, j] = total


@inlined
def solve_positive(matrix: FloatArray, right: FloatArray) -> None:
    """right <- inverse(matrix) right, for a symmetric positive definite matrix, which is overwritten (Cholesky).

    A matrix that is not positive definite leaves NaN in `right`.
    """
    n = len(matrix)
    for i in range(n):
        for j in range(i + 1):
            total = matrix[i, j]
            for k in range(j):
                total -= matrix[i, k] * matrix[j, k]
            matrix[i, j] = math.sqrt(total) if i == j else total / matrix[j, j]
    for c in range(right.shape[1]):
        for i in range(n):
            total = right[i, c]
            for k in range(i):
                total -= matrix[i, k] * right[k, c]
            right[i, c] = total / matrix[i, i]
        for i in range(n - 1, -1, -1):
            total = right[i, c]
            for k in range(i + 1, n):
                total -= matrix[k, i] * right[k, c]
            right[i, c] = total / matrix[i, i]
