"""More of each kind of input that people have: the small cases are examples of these laws."""

import math
import re
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from formation.errors import ScenarioError
from formation.formation_spec import SAME_PLACE
from formation.metrics import clearance
from formation.paths.waypoints import Waypoints
from formation.scenario.files import parse
from formation.scenario.scenario import Scenario

Point = tuple[float, float]
SEVERAL = settings(max_examples=25, deadline=None)


def scenario(points: Any, formation: Any = None, **path: Any) -> Scenario:
    return parse(
        {
            "name": "more",
            "duration": 20,
            "path": {"kind": "waypoints", "points": points, **path},
            "formation": formation or {"shape": "triangle"},
        }
    )


def course(found: Scenario) -> Any:
    assert isinstance(found.path, Waypoints)
    return found.path.course.points


def refusal(points: Any, formation: Any = None, **path: Any) -> str:
    with pytest.raises(ScenarioError) as caught:
        scenario(points, formation, **path)
    assert "\n" not in str(caught.value)
    assert len(str(caught.value)) < 600
    return str(caught.value)


@st.composite
def rounds(draw: st.DrawFn, size: float = 2.0) -> list[Point]:
    """Points of a gentle closed curve."""
    count = draw(st.integers(12, 40))
    bulge = draw(st.floats(0.0, 0.15))
    around = 2.0 * math.pi * np.arange(count) / count
    radius = size * (1.0 + bulge * np.cos(2.0 * around))
    return [(float(x), float(y)) for x, y in zip(radius * np.cos(around), radius * np.sin(around), strict=True)]


@given(rounds(), st.lists(st.tuples(st.integers(0, 11), st.integers(1, 4)), max_size=4), st.booleans())
@SEVERAL
def test_repeated_points_wherever_they_stand_change_nothing(points: Any, repeats: Any, closed: Any) -> None:
    more = [point for index, point in enumerate(points) for _ in range(1 + sum(n for i, n in repeats if i == index))]
    np.testing.assert_array_equal(course(scenario(more, closed=closed)), course(scenario(points, closed=closed)))


@given(rounds(), st.floats(-3e-7, 3e-7), st.integers(1, 3))
@SEVERAL
def test_a_seam_that_is_nearly_closed_is_closed(points: Any, off: Any, times: Any) -> None:
    length = float(np.hypot(*np.diff(np.array(points), axis=0).T).sum())
    last = (points[0][0] + off * length, points[0][1])
    np.testing.assert_array_equal(
        course(scenario([*points, *([last] * times)], closed=True)), course(scenario(points, closed=True))
    )


@given(rounds(), st.sets(st.integers(0, 11), min_size=1), st.sampled_from([1, 3, 4]))
@SEVERAL
def test_rows_of_another_length_share_one_line(points: Any, wrong: Any, columns: Any) -> None:
    rows = [[*point, 0.0, 0.0][:columns] if index in wrong else list(point) for index, point in enumerate(points)]
    line = refusal(rows)
    assert f"path.points[{min(wrong)}]" in line
    assert ("more like it" in line) == (len(wrong) > 1)


@given(rounds(), st.floats(-80, 80), st.floats(-170, 170), st.floats(0.2, 3.0))
@SEVERAL
def test_degrees_are_recognised_wherever_on_earth(points: Any, north: Any, east: Any, speed: Any) -> None:
    assume(min(abs(north), abs(east)) > 1.0)
    track = [(east + 1e-4 * x, north + 1e-4 * y) for x, y in points]  # a round of 20 to 40 m
    try:
        line = scenario(track, closed=True, speed=speed).feasibility().line
    except ScenarioError as error:
        line = str(error)
    assert "look like degrees" in line


@given(rounds(), st.floats(0.55, 2.0))
@SEVERAL
def test_a_path_that_is_too_fast_is_told_with_both_speeds(points: Any, speed: Any) -> None:
    feasibility = scenario(points, closed=True, speed=speed).feasibility()
    assert feasibility.lag > 0.0
    found = re.search(r"asks for ([\d.]+) m/s; the limit is ([\d.]+)", feasibility.line)
    assert found is not None
    assert float(found[1]) == pytest.approx(speed, rel=0.1)
    assert float(found[2]) == 0.5


@given(rounds(), st.tuples(st.floats(-1e6, 1e6), st.floats(-1e7, 1e7)))
@SEVERAL
def test_where_on_a_map_it_is_moves_the_path_and_changes_nothing_else(points: Any, origin: Any) -> None:
    t = np.linspace(-1.0, 90.0, 400)
    near = scenario(points, closed=True).path.position(t)
    far = scenario((np.array(points) + origin).tolist(), closed=True).path.position(t)
    np.testing.assert_allclose(far - origin, near, atol=1e-6)


PLACES = st.lists(st.tuples(st.floats(-1, 1), st.floats(-1, 1)), min_size=2, max_size=8)


@given(PLACES, st.data())
@SEVERAL
def test_two_robots_in_one_place_are_refused_with_both_numbers(places: Any, data: Any) -> None:
    apart = [math.dist(a, b) for i, a in enumerate(places) for b in places[:i]]
    extent = float(np.ptp(np.array(places), axis=0).max())
    assume(min(apart) > 2.0 * SAME_PLACE * extent)
    twin = data.draw(st.integers(0, len(places) - 1))
    line = refusal([(0, 0), (1, 0)], {"offsets": [*places, places[twin]]})
    assert f"robots {twin + 1} and {len(places) + 1}" in line


@given(st.permutations(range(4)))
@SEVERAL
def test_robots_that_swap_places_are_kept_apart_or_refused_with_the_time(order: Any) -> None:
    square = [(0.15, 0.15), (0.15, -0.15), (-0.15, -0.15), (-0.15, 0.15)]
    formation = {
        "offsets": square,
        "changes": [{"at": 2, "offsets": [square[i] for i in order], "reassign": False}],
    }
    try:
        found = scenario([(0, 0), (10, 0)], formation)
    except ScenarioError as error:
        line = str(error)
        assert re.search(r"robots \d and \d come within [\d.]+ m of each other at t = [\d.]+ s", line)
        assert "reassign = true" in line
        formation["changes"][0]["reassign"] = True  # type: ignore[index]
        scenario([(0, 0), (10, 0)], formation)
    else:
        slots = found.reference().positions(np.arange(0.0, 20.0, 0.01))
        assert clearance(slots) >= 0.5 * found.spacing * (1 - 1e-9)


@given(rounds(), st.integers(1, 60), st.integers(0, 2**32))
@settings(max_examples=10, deadline=None)
def test_a_recording_that_stands_still_at_first_is_told_with_the_place_or_followed(
    points: Any, count: Any, seed: Any
) -> None:
    jitter = 1e-3 * np.random.default_rng(seed).standard_normal((count, 2)) + points[0]
    found = scenario([*jitter.tolist(), *points])
    line = found.feasibility().line
    assert not line or re.search(r"points \d+ to \d+ turn|near point \d+", line)
    thinned = scenario([*jitter.tolist(), *points], least_distance=0.05)
    assert len(course(thinned)) <= len(points) + 1
