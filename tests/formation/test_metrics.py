"""Measures: zero in perfect formation, blind to a rigid motion of the whole scene, and the paper's own formulas."""

# mypy: disable-error-code="call-arg"
# (unpacked poses, numpy scalars and shapes; what strict typing of numpy makes of test arithmetic)

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from agents.kernels import paper_errors
from formation.arrays import FloatArray
from formation.metrics import error_state, pattern_errors, quantile, quantiles, tracking_error, wrapped
from formation.pattern import pattern, rotate
from formation.shapes import SHAPES, line, polygon

ANGLE = st.floats(-3.1, 3.1)
PLACE = st.floats(-5, 5)
OFFSETS = st.sampled_from([line(2, 0.1), polygon(3, 0.1), SHAPES["square"](4, 0.3), SHAPES["wedge"](5, 0.2)])


@st.composite
def two_poses(draw: st.DrawFn) -> tuple[FloatArray, FloatArray]:
    """A pair at a distance of 0.02 to 1 m, headings anyhow."""
    own = np.array([draw(PLACE), draw(PLACE), draw(ANGLE)])
    length, direction = draw(st.floats(0.02, 1.0)), draw(ANGLE)
    away = length * np.array([math.cos(direction), math.sin(direction)])
    return own, np.array([*(own[:2] + away), draw(ANGLE)])


def placed(offsets: FloatArray, x: float, y: float, theta: float) -> FloatArray:
    """Poses (n, 3) of the formation at a centre."""
    where = np.array([x, y]) + rotate(np.array(theta), offsets)
    return np.column_stack([where, np.full(len(offsets), theta)])


def moved(poses: FloatArray, angle: float, dx: float, dy: float) -> FloatArray:
    """The scene turned about the origin, then shifted."""
    places = rotate(np.array(angle), poses[..., :2]) + np.array([dx, dy])
    return np.concatenate([places, poses[..., 2:] + angle], axis=-1)


def test_wrapped_angles_are_within_half_a_turn() -> None:
    angles = np.array([0.0, 3.0, -3.0, 4.0, -4.0, 2 * math.pi, 7 * math.pi / 2])
    expected = [0.0, 3.0, -3.0, 4.0 - 2 * math.pi, 2 * math.pi - 4.0, 0.0, -math.pi / 2]
    np.testing.assert_allclose(wrapped(angles), expected, atol=1e-12)


@given(OFFSETS, PLACE, PLACE, ANGLE)
def test_errors_vanish_in_perfect_formation(offsets: Any, x: Any, y: Any, theta: Any) -> None:
    poses = placed(offsets, x, y, theta)
    distance, angle = pattern_errors(poses, placed(offsets, 0.0, 0.0, theta))
    np.testing.assert_allclose(distance, 0.0, atol=1e-12)
    np.testing.assert_allclose(angle, 0.0, atol=1e-12)
    assert tracking_error(poses, np.array([x, y])) == pytest.approx(0.0, abs=1e-12)
    p = pattern(offsets)
    for i in range(len(offsets)):
        z = error_state(poses[i], poses[i - 1], np.array([x, y, theta]), p.distance[i], theta + p.angle[i], p.centre[i])
        np.testing.assert_allclose(z, 0.0, atol=1e-12)


@given(OFFSETS, st.data(), ANGLE, PLACE, PLACE)
def test_pattern_errors_do_not_change_under_a_rigid_motion_of_the_whole_scene(
    offsets: Any, data: Any, angle: Any, dx: Any, dy: Any
) -> None:
    seed = data.draw(st.integers(0, 2**32))
    theta_r = data.draw(ANGLE)
    noise = np.random.default_rng(seed).normal(0.0, 0.01, (len(offsets), 3))
    poses = placed(offsets, 0.3, -0.2, theta_r) + noise
    slots = placed(offsets, 0.0, 0.0, theta_r)
    here = pattern_errors(poses, slots)
    there = pattern_errors(moved(poses, angle, dx, dy), moved(slots, angle, dx, dy))
    assert np.abs(here[0]).max() > 1e-6  # the formation is not perfect
    np.testing.assert_allclose(there[0], here[0], atol=1e-10)
    np.testing.assert_allclose(there[1], here[1], atol=1e-10)
    centre = np.array([[0.3, -0.2, theta_r]])
    assert tracking_error(moved(poses, angle, dx, dy), moved(centre, angle, dx, dy)[0, :2]) == pytest.approx(
        tracking_error(poses, centre[0, :2]), abs=1e-10
    )


@given(two_poses(), PLACE, PLACE, ANGLE, ANGLE, PLACE, PLACE)
def test_the_error_state_does_not_change_under_a_rigid_motion_of_the_whole_scene(
    pair: Any, x: Any, y: Any, theta: Any, angle: Any, dx: Any, dy: Any
) -> None:
    own, other = pair
    reference, centre = np.array([x, y, theta]), np.array([0.03, -0.01])
    here = error_state(own, other, reference, 0.1, theta + 0.4, centre)
    m = moved(np.array([own, other, reference]), angle, dx, dy)
    there = error_state(m[0], m[1], m[2], 0.1, theta + 0.4 + angle, centre)
    gap = there - here
    gap[[2, 4]] = wrapped(gap[[2, 4]])  # at half a turn the sign of a wrapped angle is a matter of rounding
    np.testing.assert_allclose(gap, 0.0, atol=1e-9)


@given(two_poses(), PLACE, PLACE, ANGLE, ANGLE, st.floats(-0.2, 0.2), st.floats(-0.2, 0.2))
def test_the_error_state_is_that_of_section_2_1(
    pair: Any, x_r: Any, y_r: Any, theta_r: Any, psi_r: Any, p_x: Any, p_y: Any
) -> None:
    (x_i, y_i, theta_i), (x_u, y_u, theta_u) = pair
    z = error_state(*pair, np.array([x_r, y_r, theta_r]), 0.1, psi_r, np.array([p_x, p_y]))
    # As printed below eq. (2).
    x_c, y_c, theta_c = (x_i + x_u) / 2, (y_i + y_u) / 2, (theta_i + theta_u) / 2
    length = math.sqrt((x_i - x_u) ** 2 + (y_i - y_u) ** 2)
    psi = math.atan2(x_i - x_u, y_u - y_i)
    c, s = math.cos(theta_c), math.sin(theta_c)
    cp, sp = math.cos(theta_c - psi), math.sin(theta_c - psi)
    x_e = c * (x_r - x_c) + s * (y_r - y_c) - cp * p_x - sp * p_y
    y_e = -s * (x_r - x_c) + c * (y_r - y_c) + sp * p_x - cp * p_y
    np.testing.assert_allclose(z[[0, 1, 3]], [x_e, y_e, 0.1 - length], atol=1e-11)
    for got, printed in ((z[2], theta_r - theta_c), (z[4], psi_r - psi)):
        assert abs(math.remainder(got - printed, 2 * math.pi)) < 1e-11
        assert abs(got) <= math.pi


@given(two_poses(), PLACE, PLACE, ANGLE, ANGLE)
def test_the_compiled_error_state_is_the_same(pair: Any, x_r: Any, y_r: Any, theta_r: Any, psi_r: Any) -> None:
    centre, z = np.array([0.02, -0.03]), np.empty(5)
    paper_errors.error_state(*pair, np.array([x_r, y_r, theta_r, 0.1, 0.0]), 0.1, psi_r, centre, z)
    gap = z - error_state(*pair, np.array([x_r, y_r, theta_r]), 0.1, psi_r, centre)
    gap[[2, 4]] = wrapped(gap[[2, 4]])
    np.testing.assert_allclose(gap, 0.0, atol=1e-11)


@given(two_poses(), ANGLE)
def test_pattern_errors_are_the_last_two_of_the_error_state(pair: Any, theta: Any) -> None:
    offsets = line(2, 0.1)
    p = pattern(offsets)
    distance, angle = pattern_errors(np.array(pair), placed(offsets, 0.0, 0.0, theta))
    for i in range(2):
        z = error_state(
            pair[i], pair[1 - i], np.array([0.0, 0.0, theta]), p.distance[i], theta + p.angle[i], p.centre[i]
        )
        assert distance[i] == pytest.approx(z[3], abs=1e-12)
        assert abs(math.remainder(angle[i] - z[4], 2 * math.pi)) < 1e-9


def test_a_known_displacement_gives_known_errors() -> None:
    offsets = line(2, 0.1)  # robot 2 stands left of robot 1
    poses = placed(offsets, 0.0, 0.0, 0.0)
    poses[1, 1] += 0.02  # 2 cm further left: both see 2 cm too much
    distance, angle = pattern_errors(poses, placed(offsets, 1.0, 2.0, 0.0))
    np.testing.assert_allclose(distance, [-0.02, -0.02], atol=1e-15)
    np.testing.assert_allclose(angle, 0.0, atol=1e-15)
    assert tracking_error(poses, np.zeros(2)) == pytest.approx(0.01)
    poses = placed(offsets, 0.0, 0.0, 0.0)
    poses[0, 0] += 0.1  # robot 1 a spacing ahead: the edge points 45 degrees further left
    distance, angle = pattern_errors(poses, placed(offsets, 1.0, 2.0, 0.0))
    np.testing.assert_allclose(distance, 0.1 - 0.1 * math.sqrt(2), atol=1e-15)
    np.testing.assert_allclose(angle, -math.pi / 4, atol=1e-12)


def test_many_times_are_measured_at_once_as_one_by_one() -> None:
    generator = np.random.default_rng(4)
    poses, slots = generator.normal(size=(2, 7, 3, 3))
    centre = generator.normal(size=(7, 2))
    distance, angle = pattern_errors(poses, slots)
    assert distance.shape == angle.shape == (7, 3)
    tracking = tracking_error(poses, centre)
    for k in range(7):
        one = pattern_errors(poses[k], slots[k])
        np.testing.assert_array_equal(one[0], distance[k])
        np.testing.assert_array_equal(one[1], angle[k])
        assert tracking_error(poses[k], centre[k]) == tracking[k]


@given(st.lists(st.floats(0.0, 1.0) | st.just(math.nan), max_size=30))
def test_quantiles_are_those_that_one_gets_one_by_one(values: list[float]) -> None:
    shares = (0.25, 0.5, 0.95, 1.0)
    assert quantiles(np.array(values), *shares) == [quantile(np.array(values), share) for share in shares]
