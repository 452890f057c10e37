"""Points made smooth: never further off than allowed, as little bent as that permits."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.interpolate import make_smoothing_spline

from formation.paths.smoothing import _smooth, smoothed

STAIRS = np.array([[0.05 * (i // 2 + i % 2), 0.05 * (i // 2)] for i in range(40)])


@given(st.integers(0, 2**32), st.booleans(), st.floats(0.001, 0.3))
@settings(max_examples=40)
def test_no_point_is_moved_further_than_allowed(seed: Any, closed: Any, deviation: Any) -> None:
    points = np.cumsum(np.random.default_rng(seed).normal(size=(12, 2)), axis=0)
    found = smoothed(points, deviation, closed=closed)
    off = np.hypot(*(found - points).T).max()
    assert 0.0 < off <= deviation
    assert off > 0.9 * deviation  # random walks are never straight: it is used


def test_it_is_the_smoothing_spline() -> None:
    generator = np.random.default_rng(3)
    points = np.cumsum(generator.uniform(0.2, 1.0, (15, 2)), axis=0)
    gaps = np.hypot(*np.diff(points, axis=0).T)
    knots = np.concatenate([[0.0], np.cumsum(gaps)])
    for factor in (1e-3, 0.1, 10.0):
        expected = np.stack([make_smoothing_spline(knots, axis, lam=factor)(knots) for axis in points.T], axis=1)
        np.testing.assert_allclose(_smooth(points, gaps, factor), expected, atol=1e-8)


def test_a_straight_line_stays_where_it_is() -> None:
    line = np.linspace([0.0, 0.0], [3.0, 1.0], 20)
    np.testing.assert_allclose(smoothed(line, 0.1, closed=False), line, atol=1e-6)


def test_stairs_become_a_slope() -> None:
    found = smoothed(STAIRS, 0.05, closed=False)
    turns = np.abs(np.diff(np.unwrap(np.arctan2(*np.diff(found, axis=0).T))))
    assert turns.max() < 0.05


def test_without_a_deviation_nothing_moves() -> None:
    assert smoothed(STAIRS, 0.0, closed=False) is STAIRS


@pytest.mark.parametrize("first", [0, 7, 19])
def test_where_a_closed_curve_begins_does_not_matter(first: Any) -> None:
    around = 2 * np.pi * np.arange(20) / 20
    ring = np.stack([np.cos(around), np.sin(around)], axis=1) * (1 + 0.1 * np.sin(5 * around))[:, None]
    whole = smoothed(ring, 0.05, closed=True)
    turned = smoothed(np.roll(ring, -first, axis=0), 0.05, closed=True)
    np.testing.assert_allclose(np.roll(turned, first, axis=0), whole, atol=2e-3)
