"""The reference paths: Table 1 of the paper, continuity, and headings as the paper samples them."""

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import TypeAdapter, ValidationError

from formation.paths.kinds import AnyPath, Circle, Corner, Figure8, Line, Sinusoid, Spiral
from formation.paths.path import Path, heading
from formation.paths.waypoints import Waypoints

TIMES = np.linspace(-3.0, 200.0, 1017)
PATHS: list[Path] = [
    Figure8(kind="figure8"),
    Circle(kind="circle"),
    Sinusoid(kind="sinusoid"),
    Spiral(kind="spiral"),
    Corner(kind="corner"),
    Line(kind="line", heading=0.4),
    Waypoints(kind="waypoints", points=[(0, 0), (1, 0.3), (2, -0.3), (3, 1)]),
    Waypoints(kind="waypoints", points=[(0, 0), (1, 0), (1, 1), (0, 1)], closed=True, speed=0.2),
]
each_path = pytest.mark.parametrize("path", PATHS, ids=lambda path: type(path).__name__)


def test_the_paths_are_those_of_table_1() -> None:
    t = TIMES
    table = {
        0: (np.sin(t / 10), np.sin(t / 20)),
        1: (0.8 * np.cos(t / 20), 0.8 * np.sin(t / 20)),
        2: (t / 10, 0.8 * np.sin(t / 10)),
        3: (0.01 * t * np.cos(t / 10), 0.01 * t * np.sin(t / 10)),  # erratum 9 mended
    }
    for index, columns in table.items():
        np.testing.assert_allclose(PATHS[index].position(t), np.stack(columns, axis=1), atol=1e-12)


def test_the_corner_is_that_of_the_second_test() -> None:
    path = Corner(kind="corner", at=20.0)
    before, after = np.array([0.0, 10.0, 20.0]), np.array([20.0, 25.0, 50.0])
    np.testing.assert_allclose(path.position(before), np.stack([0 * before, 0.1 * before], axis=1), atol=1e-15)
    np.testing.assert_allclose(path.position(after), np.stack([0.1 * (after - 20), 0.1 * after], axis=1), atol=1e-15)
    turn = heading(path, np.array([21.0]), 0.1) - heading(path, np.array([19.0]), 0.1)
    assert turn[0] == pytest.approx(-math.pi / 4)


@each_path
def test_positions_have_the_shape_of_the_times_and_a_last_axis_of_two(path: Any) -> None:
    for t in (np.array(3.0), TIMES, TIMES[:12].reshape(3, 4)):
        assert path.position(t).shape == (*t.shape, 2)
        assert heading(path, t, 0.1).shape == t.shape


@each_path
def test_a_position_does_not_depend_on_the_other_times_asked_for(path: Any) -> None:
    whole = path.position(TIMES)
    for index in (0, 7, 500, -1):
        np.testing.assert_allclose(path.position(TIMES[index : index + 1 or None])[0], whole[index], atol=1e-12)


@each_path
def test_a_path_is_continuous(path: Any) -> None:
    t = np.linspace(-1.0, 130.0, 13_101)  # 10 ms
    steps = np.hypot(*np.diff(path.position(t), axis=0).T)
    assert 0.0 < steps.max() < 0.01 * 0.4  # no path is faster than 0.4 m/s (the spiral at 130 s: 0.13 m/s)


@each_path
def test_a_path_with_a_period_repeats(path: Any) -> None:
    if path.period is None:
        assert isinstance(path, Sinusoid | Spiral | Corner | Line | Waypoints)
        # it is open: it does not come back
        assert np.hypot(*(path.position(np.array(130.0)) - path.position(np.array(0.0)))) > 0.5
    else:
        np.testing.assert_allclose(path.position(TIMES + path.period), path.position(TIMES), atol=1e-9)


def test_closed_paths_are_figure8_circle_and_closed_waypoints() -> None:
    assert [path.period is not None for path in PATHS] == [True, True, False, False, False, False, False, True]
    assert PATHS[0].period == pytest.approx(2 * math.pi / 0.05)


@given(st.floats(-3, 3), st.floats(0.01, 1.0), st.floats(0.0, 100.0))
def test_the_heading_of_a_line_is_its_own(angle: Any, speed: Any, t: Any) -> None:
    path = Line(kind="line", heading=angle, speed=speed)
    assert heading(path, np.array(t), 0.1) == pytest.approx(angle, abs=1e-9)


@each_path
def test_the_heading_is_the_direction_of_the_last_interval(path: Any) -> None:
    t = TIMES[20:]
    step = path.position(t) - path.position(t - 0.1)
    theta = heading(path, t, 0.1)
    length = np.hypot(step[:, 0], step[:, 1])
    np.testing.assert_allclose(length * np.cos(theta), step[:, 0], atol=1e-12)
    np.testing.assert_allclose(length * np.sin(theta), step[:, 1], atol=1e-12)


@pytest.mark.parametrize("path", PATHS[6:], ids=["open", "closed"])
def test_waypoints_are_passed_in_order_at_constant_speed(path: Any) -> None:
    t = np.linspace(0.0, 60.0, 60_001)
    p = path.position(t)
    speed = np.hypot(*np.diff(p, axis=0).T) / 1e-3
    assert np.abs(speed / path.speed - 1).max() < 5e-3  # the spline's own promise is about a tenth of a per cent
    passed = [int(np.hypot(*(p - np.array(q)).T).argmin()) for q in path.points]
    assert passed == sorted(passed)
    for index, q in zip(passed, path.points, strict=True):
        assert np.hypot(*(p[index] - np.array(q))) < 1e-3


@pytest.mark.parametrize(
    ("table", "words"),
    [
        ({"kind": "square"}, "square"),
        ({}, "kind"),
        ({"kind": "circle", "radius": 0.0}, "greater than 0"),
        ({"kind": "circle", "radius": float("inf")}, "finite"),
        ({"kind": "circle", "size": 1.0}, "size"),
        ({"kind": "waypoints"}, "points"),
        ({"kind": "waypoints", "points": [[0, 0]]}, "at least 2"),
        ({"kind": "waypoints", "points": [[0, 0], [0, 0]]}, "differ"),
        ({"kind": "waypoints", "points": [[0, 0], [1, 1], [0, 0]], "closed": True}, "differ"),
        ({"kind": "waypoints", "points": [[0, 0], [1, 1]], "closed": True}, "at least 3"),
        ({"kind": "waypoints", "points": [[0, 0], [1, float("nan")]]}, "finite"),
    ],
)
def test_a_wrong_path_is_refused_with_the_reason(table: dict[str, Any], words: str) -> None:
    with pytest.raises(ValidationError, match=words):
        TypeAdapter(AnyPath).validate_python(table)
