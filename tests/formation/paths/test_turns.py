"""Where a path turns more tightly than a formation: found wherever it is, and nowhere else."""

import math
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from formation.paths.kinds import Circle, Corner
from formation.paths.path import Path
from formation.paths.turns import Turn, spike, tight_turns
from formation.paths.waypoints import Waypoints


def turns(path: Path, reach: float = 0.1, until: float = 60.0) -> list[Turn]:
    return tight_turns(path, reach=reach, interval=0.1, step=0.01, until=until)


@given(st.floats(0.05, 1.0), st.floats(0.05, 1.0))
@settings(max_examples=40)
def test_a_circle_is_tight_exactly_if_its_radius_is_below_the_reach(radius: Any, reach: Any) -> None:
    found = turns(Circle(kind="circle", radius=radius, rate=0.1 / radius), reach)
    if radius < 0.9 * reach:
        assert found[0].radius == pytest.approx(radius, rel=0.02)
    elif radius > reach:
        assert found == []


def test_a_corner_that_the_path_declares_is_none() -> None:
    assert turns(Corner(kind="corner", at=5.0)) == []


@given(st.floats(0.3, 2.0), st.floats(-math.pi, math.pi))
@settings(max_examples=30)
def test_turning_back_is_found_where_it_is(out: Any, heading: Any) -> None:
    points = [(0.0, 0.0), (out * math.cos(heading), out * math.sin(heading)), (0.0, 0.0)]
    path = Waypoints(kind="waypoints", points=points)
    (found,) = turns(path)
    assert found.angle == pytest.approx(math.pi, abs=0.02)
    assert found.place.startswith("points 1 to 3 turn by 180 degrees at")
    assert found.at == pytest.approx(path.course.travel.at_knots[1] / 0.1, abs=0.11)
    assert spike(path, 0.1) == ""  # it goes back over what it came by


@given(st.floats(0.5, 3.0), st.floats(0.002, 0.02))
@settings(max_examples=30)
def test_a_spike_is_refused_unless_it_is_smoothed(length: Any, gap: Any) -> None:
    points = [(0.0, 0.0), (length, 0.0), (0.0, gap * length)]
    assert "points 1 to 3 turn by 17" in spike(Waypoints(kind="waypoints", points=points), 0.06)
    assert spike(Waypoints(kind="waypoints", points=points, smoothing=0.05), 0.06) == ""
