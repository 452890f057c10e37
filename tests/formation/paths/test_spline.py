"""Laws of the spline: it goes through its points, its curvature has no jumps, and it is travelled at constant speed."""

# mypy: disable-error-code="no-any-return"
# (unpacked poses, numpy scalars and shapes; what strict typing of numpy makes of test arithmetic)

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from formation.arrays import FloatArray
from formation.paths.spline import Spline

SQUARE = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
BEND = np.array([[0.0, 0.0], [1.0, 0.2], [1.5, 1.0], [3.0, 1.0]])


@st.composite
def waypoints(draw: st.DrawFn) -> FloatArray:
    """Points on a rough ring: never too near to their neighbours."""
    n = draw(st.integers(3, 8))
    radii = np.array(draw(st.lists(st.floats(0.5, 2.0), min_size=n, max_size=n)))
    around = 2 * math.pi * np.arange(n) / n
    return radii[:, None] * np.stack([np.cos(around), np.sin(around)], axis=1)


@given(waypoints(), st.booleans())
def test_a_curve_goes_through_its_points(points: Any, closed: Any) -> None:
    curve = Spline.through(points, closed=closed)
    np.testing.assert_allclose(curve(curve.knots[: len(points)]), points, atol=1e-12)


@given(waypoints(), st.booleans())
def test_the_first_two_derivatives_have_no_jumps_at_the_knots(points: Any, closed: Any) -> None:
    curve = Spline.through(points, closed=closed)
    inner = curve.knots[:-1] if closed else curve.knots[1:-1]
    h = 1e-4

    def side(sign: float) -> tuple[FloatArray, FloatArray]:
        p = [curve(inner + sign * n * h) for n in range(4)]
        first = sign * (-11 * p[0] + 18 * p[1] - 9 * p[2] + 2 * p[3]) / (6 * h)
        second = (2 * p[0] - 5 * p[1] + 4 * p[2] - p[3]) / h**2
        return first, second

    left, right = side(-1.0), side(1.0)
    np.testing.assert_allclose(left[0], right[0], atol=1e-8)
    # One-sided second differences of a cubic are exact; what is left is rounding of 1e-16 / h^2.
    np.testing.assert_allclose(left[1], right[1], atol=1e-5)


def test_a_closed_curve_repeats() -> None:
    curve = Spline.through(SQUARE, closed=True)
    s = np.linspace(0.0, curve.length, 50)
    np.testing.assert_allclose(curve(s + curve.length), curve(s), atol=1e-12)
    np.testing.assert_allclose(curve(s - 3 * curve.length), curve(s), atol=1e-12)


def test_an_open_curve_goes_straight_on_past_its_ends() -> None:
    curve = Spline.through(BEND, closed=False)
    for end, s in ((0.0, np.array([-3.0, -2.0, -1.0, 0.0])), (curve.length, curve.length + np.arange(4.0))):
        steps = np.diff(curve(s), axis=0)
        np.testing.assert_allclose(steps, np.broadcast_to(steps[0], steps.shape), atol=1e-12)
        h = 1e-6
        slope = (curve(np.array([end + h])) - curve(np.array([end - h])))[0] / (2 * h)
        np.testing.assert_allclose(steps[0], slope, atol=1e-6)


def test_the_ends_of_an_open_curve_have_no_curvature() -> None:
    curve = Spline.through(BEND, closed=False)
    h = 1e-4
    for at, sign in ((0.0, 1.0), (curve.length, -1.0)):
        p = curve(np.array([at + sign * n * h for n in range(4)]))
        second = (2 * p[0] - 5 * p[1] + 4 * p[2] - p[3]) / h**2
        np.testing.assert_allclose(second, 0.0, atol=1e-5)


def test_two_points_are_joined_by_a_straight_line() -> None:
    curve = Spline.through(np.array([[0.0, 0.0], [3.0, 4.0]]), closed=False)
    assert curve.length == pytest.approx(5.0)
    s = np.linspace(-1.0, 6.0, 15)
    np.testing.assert_allclose(curve(s), s[:, None] * np.array([0.6, 0.8]), atol=1e-12)


@given(waypoints(), st.booleans())
@settings(max_examples=15)
def test_by_arc_length_the_speed_is_one(points: Any, closed: Any) -> None:
    curve = Spline.through(points, closed=closed).by_arc_length()
    s = np.linspace(0.0, curve.length, 20_000)
    speed = np.hypot(*np.diff(curve(s), axis=0).T) / np.diff(s)
    # At a sharp bend of this fine sampling a chord is still up to a thousandth shorter than its arc.
    assert np.abs(speed - 1).max() < 2e-3
    assert np.median(np.abs(speed - 1)) < 1e-6


def test_reparametrising_does_not_change_the_curve() -> None:
    for points in (SQUARE, 0.3 * SQUARE[::-1], BEND):
        before = Spline.through(points, closed=len(points) == 4 and points is not BEND)
        after = before.by_arc_length()
        cloud = before(np.linspace(0.0, before.length, 4000))
        for p in after(np.linspace(0.0, after.length, 50)):
            # Samples of the first curve stand about 1 mm apart; half of that beside it is on it.
            assert np.hypot(*(cloud - p).T).min() < 1.5e-3


def test_a_fine_polygon_of_a_circle_has_its_length() -> None:
    around = 2 * math.pi * np.arange(24) / 24
    curve = Spline.through(np.stack([np.cos(around), np.sin(around)], axis=1), closed=True).by_arc_length()
    assert curve.length == pytest.approx(2 * math.pi, rel=1e-4)
    radii = np.hypot(*curve(np.linspace(0.0, curve.length, 500)).T)
    np.testing.assert_allclose(radii, 1.0, atol=1e-4)
