"""Patterns: derived from offsets alone, and the paper's parameters in its own cases (errata 6 and 7 mended)."""

# mypy: disable-error-code="arg-type, no-any-return"
# (unpacked poses, numpy scalars and shapes; what strict typing of numpy makes of test arithmetic)

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from formation.arrays import FloatArray
from formation.pattern import downstream, pattern, rotate, upstream
from formation.shapes import FIXED_SIZES, SHAPES, column, line, polygon, square, wedge

SIZES = {name: [FIXED_SIZES[name]] if name in FIXED_SIZES else [2, 3, 5, 16, 64] for name in SHAPES}
CASES = [(name, n) for name, sizes in SIZES.items() for n in sizes]


@st.composite
def any_offsets(draw: st.DrawFn) -> FloatArray:
    """Distinct points with mean zero: a jittered ring, turned anyhow."""
    n = draw(st.integers(2, 8))
    around = 2 * math.pi * np.arange(n) / n + draw(st.floats(-math.pi, math.pi))
    radii = np.array(draw(st.lists(st.floats(0.05, 1.0), min_size=n, max_size=n)))
    points = radii[:, None] * np.stack([np.cos(around), np.sin(around)], axis=1)
    return points - points.mean(axis=0)


def angle_gap(a: FloatArray, b: FloatArray | float) -> float:
    return float(np.abs(np.angle(np.exp(1j * (np.asarray(a) - b)))).max())


def test_the_rings_are_those_of_figure_1() -> None:
    assert [upstream(i, 2) for i in (1, 2)] == [2, 1]
    assert [upstream(i, 3) for i in (1, 2, 3)] == [3, 1, 2]
    assert [upstream(i, 4) for i in (1, 2, 3, 4)] == [4, 1, 2, 3]


@given(st.integers(2, 64), st.data())
def test_upstream_and_downstream_undo_each_other_and_the_ring_is_one_cycle(n: Any, data: Any) -> None:
    robot = data.draw(st.integers(1, n))
    assert upstream(downstream(robot, n), n) == robot == downstream(upstream(robot, n), n)
    seen = [robot]
    while (following := downstream(seen[-1], n)) != robot:
        seen.append(following)
    assert sorted(seen) == list(range(1, n + 1))


@pytest.mark.parametrize(("shape", "n"), CASES)
def test_offsets_have_mean_zero_and_no_two_robots_stand_in_one_place(shape: Any, n: Any) -> None:
    offsets = SHAPES[shape](n, 0.1)
    assert offsets.shape == (n, 2)
    np.testing.assert_allclose(offsets.mean(axis=0), 0.0, atol=1e-12)
    gaps = np.hypot(*(offsets[:, None] - offsets[None]).T)
    assert gaps[~np.eye(n, dtype=bool)].min() > 0.1 - 1e-9


@pytest.mark.parametrize(("shape", "n"), CASES)
def test_neighbours_stand_at_the_spacing(shape: Any, n: Any) -> None:
    gaps = np.hypot(*np.diff(SHAPES[shape](n, 0.25), axis=0).T)
    np.testing.assert_allclose(gaps, 0.25, atol=1e-12)


def test_the_shapes_look_as_their_names_say() -> None:
    across = line(3, 0.1)
    np.testing.assert_allclose(across, [[0, -0.1], [0, 0], [0, 0.1]], atol=1e-15)
    np.testing.assert_allclose(column(3, 0.1), [[0.1, 0], [0, 0], [-0.1, 0]], atol=1e-15)
    np.testing.assert_allclose(square(4, 0.2), [[0.1, 0.1], [-0.1, 0.1], [-0.1, -0.1], [0.1, -0.1]], atol=1e-15)
    triangle = polygon(3, 0.1)
    assert triangle[0] == pytest.approx([0.1 / math.sqrt(3), 0.0])
    assert triangle[1][1] > 0 > triangle[2][1]  # counter-clockwise
    v = wedge(5, 0.1)
    assert v[2, 0] == max(v[:, 0])  # the point of the V is in front
    assert v[0, 1] < 0 < v[4, 1]
    assert np.dot(v[0] - v[2], v[4] - v[2]) == pytest.approx(0.0)


@given(any_offsets())
def test_the_pattern_leads_from_a_robot_to_its_upstream_neighbour(offsets: Any) -> None:
    """p_-i - p_i = l (-sin psi, cos psi), section 1 of the theory."""
    p = pattern(offsets)
    edge = p.distance[:, None] * np.stack([-np.sin(p.angle), np.cos(p.angle)], axis=1)
    for i in range(1, len(offsets) + 1):
        other = offsets[upstream(i, len(offsets)) - 1]
        np.testing.assert_allclose(offsets[i - 1] + edge[i - 1], other, atol=1e-12)


@given(any_offsets())
def test_every_pair_infers_the_same_centre(offsets: Any) -> None:
    p = pattern(offsets)
    middles = (offsets + np.roll(offsets, 1, axis=0)) / 2
    np.testing.assert_allclose(middles + rotate(p.angle, p.centre), 0.0, atol=1e-12)


@given(any_offsets(), st.floats(-math.pi, math.pi))
def test_turning_the_formation_turns_the_angles_and_nothing_else(offsets: Any, angle: Any) -> None:
    before, after = pattern(offsets), pattern(rotate(np.array(angle), offsets))
    np.testing.assert_allclose(after.distance, before.distance, atol=1e-12)
    np.testing.assert_allclose(after.centre, before.centre, atol=1e-12)
    assert angle_gap(after.angle - before.angle, angle) < 1e-9


@given(any_offsets(), st.integers(1, 7))
def test_renumbering_along_the_ring_renumbers_the_pattern(offsets: Any, turn: Any) -> None:
    before, after = pattern(offsets), pattern(np.roll(offsets, turn, axis=0))
    for field in ("distance", "angle", "centre"):
        np.testing.assert_array_equal(getattr(after, field), np.roll(getattr(before, field), turn, axis=0))


def test_two_robots_in_line_have_the_parameters_of_the_first_test() -> None:
    """q_r^1 = (0.1, theta_r), q_r^2 = (0.1, theta_r + pi) with erratum 7 mended, and p_v = 0."""
    p = pattern(line(2, 0.1))
    np.testing.assert_allclose(p.distance, 0.1, atol=1e-15)
    assert angle_gap(p.angle, np.array([0.0, math.pi])) < 1e-12
    np.testing.assert_allclose(p.centre, 0.0, atol=1e-15)


def test_the_triangle_has_the_parameters_of_the_second_test() -> None:
    """l_r = 0.1 and p_v = (sqrt(3)/6 l, 0) for all three pairs, erratum 6 mended."""
    p = pattern(polygon(3, 0.1))
    np.testing.assert_allclose(p.distance, 0.1, atol=1e-15)
    np.testing.assert_allclose(p.centre, [[math.sqrt(3) / 6 * 0.1, 0.0]] * 3, atol=1e-15)
    # the three edges close: each is turned by 120 degrees against the one before
    assert angle_gap(np.diff(p.angle), 2 * math.pi / 3) < 1e-12


def test_patterns_are_read_only() -> None:
    p = pattern(line(2, 0.1))
    for array in (p.distance, p.angle, p.centre):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 1.0


@given(st.floats(-7, 7), st.floats(-7, 7))
def test_rotations_add_and_keep_lengths(a: Any, b: Any) -> None:
    vectors = np.array([[1.0, 0.0], [0.3, -2.0]])
    np.testing.assert_allclose(
        rotate(np.array(a), rotate(np.array(b), vectors)), rotate(np.array(a + b), vectors), atol=1e-12
    )
    assert rotate(np.array(math.pi / 2), vectors)[0] == pytest.approx([0.0, 1.0], abs=1e-15)
