"""Laws of stopping in time: the distance that it takes is the one that is there."""

import math
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from formation.clear.stopping import ENDLESS, stopping_speed
from formation.scenario.files import load

AVOID = {"robots": {"avoid": True}}


@given(st.floats(1e-4, 10.0), st.floats(0.01, 2.0), st.floats(0.1, 10.0))
def test_reaction_and_braking_take_the_gap(gap: float, react: float, brake: float) -> None:
    s = stopping_speed(gap, react, brake)
    assert s * react + s * s / (2.0 * brake) == pytest.approx(gap, rel=1e-6)
    assert stopping_speed(gap, react, 2.0 * ENDLESS) == gap / react


def top(preset: str, spacing: float = 0.1, *, avoid: bool = True) -> float:
    """Largest speed of a slot of the square on the figure 8 [m/s]."""
    changes: dict[str, Any] = {"bodies": preset, "formation": {"spacing": spacing}, "robots": {"avoid": avoid}}
    return float(load("follow-the-leader", changes).reference().block(0).inputs[:, :, 0].max())


def test_slots_are_as_fast_as_robots_can_stop_behind_each_other() -> None:
    free = top("rough", avoid=False)
    assert top("ideal") == free
    assert top("rough") < top("camera") < free
    assert top("rough", 0.2) == pytest.approx(free, rel=1e-2)


def test_the_report_says_why_and_a_formation_without_room_goes_on() -> None:
    assert "with robots.avoid" in load("square-figure8", {**AVOID, "bodies": "rough"}).feasibility().line
    assert load("square-figure8", {"bodies": "rough"}).feasibility().line == ""
    assert top("camera", 0.0701) == pytest.approx(0.95 * 0.05, rel=1e-3)


def test_orders_of_a_driven_formation_are_cut_to_it() -> None:
    speeds = [load("drive-me", {**AVOID, "bodies": preset}).law.speed for preset in ("rough", "camera", "ideal")]
    assert speeds == sorted(speeds)
    assert math.isclose(speeds[2], 0.95 * 0.225 / 1.4)
    assert load("drive-me").law.speed > speeds[2]
