"""Systems with few diagonals: what scipy finds."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.linalg import solve_banded, solveh_banded

from formation.paths.banded import cyclic_tridiagonal, pentadiagonal, tridiagonal

seeds = st.integers(0, 2**32)
sizes = st.integers(3, 40)


@given(seeds, sizes)
def test_tridiagonal(seed: Any, n: Any) -> None:
    generator = np.random.default_rng(seed)
    lower, upper = generator.uniform(-1, 1, (2, n))
    diagonal, right = generator.uniform(2.5, 4, n), generator.normal(size=(n, 2))
    bands = np.array([np.append(0.0, upper[:-1]), diagonal, np.append(lower[1:], 0.0)])
    np.testing.assert_allclose(
        tridiagonal(lower, diagonal, upper, right), solve_banded((1, 1), bands, right), atol=1e-13
    )


@given(seeds, sizes)
def test_a_system_that_goes_round(seed: Any, n: Any) -> None:
    generator = np.random.default_rng(seed)
    lower, upper = generator.uniform(-1, 1, (2, n))
    diagonal, right = generator.uniform(2.5, 4, n), generator.normal(size=(n, 2))
    whole = np.diag(diagonal)
    for i in range(n):
        whole[i, i - 1] += lower[i]
        whole[i, (i + 1) % n] += upper[i]
    np.testing.assert_allclose(whole @ cyclic_tridiagonal(lower, diagonal, upper, right), right, atol=1e-12)


@given(seeds, sizes)
def test_pentadiagonal(seed: Any, n: Any) -> None:
    generator = np.random.default_rng(seed)
    first, second = generator.uniform(-1, 1, n - 1), generator.uniform(-1, 1, n - 2)
    diagonal, right = generator.uniform(4.5, 6, n), generator.normal(size=(n, 2))
    bands = np.array([diagonal, np.append(first, 0.0), np.append(second, [0.0, 0.0])])
    expected = solveh_banded(bands, right, lower=True)
    np.testing.assert_allclose(pentadiagonal(diagonal, first, second, right), expected, atol=1e-12)


@pytest.mark.parametrize("size", [1, 2])
def test_the_smallest_systems(size: Any) -> None:
    diagonal, right = np.full(size, 2.0), np.ones((size, 2))
    found = pentadiagonal(diagonal, np.zeros(size - 1), np.zeros(0), right)
    np.testing.assert_allclose(found, 0.5)
