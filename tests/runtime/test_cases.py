"""Small inputs of the kinds that people have: each is followed, or one line names the place where it cannot be."""

import math
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from formation.errors import ScenarioError
from formation.metrics import clearance
from formation.scenario.files import load, parse, shipped
from formation.scenario.scenario import Scenario
from runtime.inprocess import Simulation

CASES = Path(__file__).parent.parent / "cases"
SHARP = ["out-and-back", "square-corners", "near-duplicate", "grid-centreline"]
SMOOTH = "path.smoothing=0.05"


def case(name: str, *overrides: str) -> Scenario:
    return load(str(CASES / f"{name}.toml"), list(overrides))


def asked(scenario: Scenario) -> Any:
    """The largest v and omega of all slots, as shares of the limits."""
    reference = scenario.reference(rounded=True)
    blocks = [reference.block(k).inputs for k in range(0, scenario.ticks, 2000)]
    return np.abs(np.concatenate(blocks)[: scenario.ticks]).max(axis=(0, 1)) / [
        scenario.robots.limits.v,
        scenario.robots.limits.omega,
    ]


def closest(scenario: Scenario) -> float:
    """The least distance between two robots, in spacings."""
    return clearance(Simulation(scenario).simulate().poses) / scenario.spacing


@pytest.mark.parametrize("name", [*SHARP, "standing-then-driving"])
def test_a_turn_that_is_too_tight_is_told_in_a_line_with_its_place_and_driven(name: Any) -> None:
    scenario = case(name)
    line = scenario.feasibility().line
    assert "\n" not in line
    assert re.match(r"points \d+ to \d+ turn by \d+.* degrees at .* m|the slot of robot .*near point \d+, at", line)
    assert "path.smoothing = 0.05" in line
    assert asked(scenario).max() <= 1.1  # within a tick of a turn on the spot, two turn rates meet
    assert closest(scenario) > 0.9


def test_the_place_is_that_of_the_turn() -> None:
    found = re.match(r"points 2 to 4 turn by 180 degrees at (.*) m:", case("out-and-back").feasibility().line)
    assert found is not None
    # The third of five points; the heading is that of the last interval, in which 1 cm is driven.
    assert float(found[1]) == pytest.approx(math.hypot(1.2, 0.6), abs=0.01)


@pytest.mark.parametrize("name", [*SHARP, "cusp"])
def test_smoothed_it_is_followed_within_the_limits(name: Any) -> None:
    scenario = case(name, SMOOTH)
    assert asked(scenario).max() <= 1.1
    assert closest(scenario) > 0.9


@pytest.mark.parametrize("name", ["square-corners", "near-duplicate", "grid-centreline"])
def test_smoothed_there_is_nothing_to_tell(name: Any) -> None:
    assert case(name, SMOOTH).feasibility().line == ""


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("cusp", ["path: points 1 to 3 turn by 179", "at 1.58 m", "radius", "smoothing"]),
        ("same-place", ["robots 2 and 4", "0 m apart"]),
        ("swap-places", ["changes[0]", "robots 1 and 2", "0.0000 m", "t = ", "reassign = true"]),
        ("three-columns", ["path.points[0]: expected 2 values; got 3 (and 119 more like it)"]),
    ],
)
def test_what_nobody_can_follow_is_refused_in_a_line(name: Any, words: Any) -> None:
    with pytest.raises(ScenarioError) as caught:
        case(name)
    assert "\n" not in str(caught.value)
    for word in words:
        assert word in str(caught.value), str(caught.value)


def test_robots_that_change_places_may_take_the_nearest_ones() -> None:
    again = "formation.changes=[{at = 4, offsets = [[-0.075, 0], [0.075, 0]], reassign = true}]"
    assert case("swap-places", again).feasibility().line == ""


def test_degrees_are_recognised() -> None:
    assert "look like degrees" in case("degrees-as-metres").feasibility().line


def test_a_path_that_is_too_fast_is_told_and_slows_down_for_all() -> None:
    scenario = case("too-fast-for-all")
    assert scenario.feasibility().line.startswith("the path asks for 0.4 m/s; the limit is 0.3")
    simulation = Simulation(scenario)
    trace = simulation.simulate()
    distance, _, tracking = trace.errors()
    assert np.abs(distance).max() < 1e-4
    assert tracking.max() < 1e-3
    driven = trace.poses[-1, :, 0].mean()
    lag = simulation.world.summary()["reference_lag_s"]
    assert driven == pytest.approx(0.4 * (scenario.duration - lag), abs=1e-3)
    assert 0.9 * 0.3 < driven / scenario.duration < 0.3


@pytest.mark.parametrize(
    ("path", "formation", "words"),
    [
        ({"kind": "circle", "radius": 0.5, "rate": 0.9}, {"spacing": 0.3}, "the slot of robot 3 asks for 0."),
        ({"kind": "line", "speed": 0.4}, {"changes": [{"at": 3, "over": 0.5, "shape": "line"}]}, "the slot of robot"),
        ({"kind": "circle", "radius": 0.15, "rate": 2.5}, {}, "rad/s; the limit is 2"),
        ({"kind": "figure8", "scale": 0.5, "rate": 0.5}, {}, "the slot of robot"),
    ],
)
def test_one_slot_a_change_or_a_turn_rate_suffices(path: Any, formation: Any, words: Any) -> None:
    scenario = parse({"name": "fast", "duration": 15, "path": path, "formation": {"shape": "triangle", **formation}})
    assert words in scenario.feasibility().line
    assert scenario.feasibility().lag > 0.01
    assert asked(scenario).max() <= 1.02
    assert closest(scenario) > 0.5


@pytest.mark.parametrize("name", [*shipped(), *(CASES / f"{n}.toml" for n in ("many-points", "seam-almost-closed"))])
def test_what_can_be_followed_is_not_remarked_upon_and_runs_by_the_clock(name: Any) -> None:
    scenario = load(str(name))
    assert scenario.feasibility().line == ""
    if scenario.path.kind == "driven":  # it has no clock of its own: it stands until it is ordered to move
        return
    t = np.linspace(0.0, scenario.duration, 999)
    np.testing.assert_array_equal(scenario.reference().centre(t), scenario.path.position(t))
    assert scenario.reference().lag(scenario.duration) == 0.0


@pytest.mark.parametrize("name", ["many-points", "repeated-points", "seam-almost-closed", "utm-metres"])
def test_these_are_followed_exactly(name: Any) -> None:
    simulation = Simulation(case(name))
    distance, _, tracking = simulation.simulate().errors()
    assert np.abs(distance).max() < 1e-4
    assert tracking.max() < 1e-3


def test_the_summary_does_not_depend_on_where_on_a_map_it_is() -> None:
    far = case("utm-metres")
    origin = np.array(far.path.model_dump()["points"])[0]
    near = parse(
        {
            **far.model_dump(exclude_unset=True),
            "path": {**far.path.model_dump(exclude_unset=True), "points": (far.path.points - origin).tolist()},  # type: ignore[union-attr]
        }
    )
    one, other = (Simulation(scenario) for scenario in (far, near))
    gap = (one.simulate().poses - other.simulate().poses)[..., :2] - origin
    assert np.abs(gap).max() < 1e-5
    for key in ("1", "2", "3"):
        figures = [s.world.summary()["robots"][key]["distance_error_m"]["max"] for s in (one, other)]
        assert abs(figures[0] - figures[1]) < 2e-6


@st.composite
def hairpins(draw: st.DrawFn) -> list[tuple[float, float]]:
    """Points with sharp turns, repeats and back-tracking, as people record or draw them."""
    points, heading = [(0.0, 0.0)], 0.0
    for turn in draw(st.lists(st.sampled_from([0, 0, 20, 60, 90, -90, 140]), min_size=2, max_size=5)):
        heading += math.radians(turn)
        way = draw(st.floats(0.2, 0.6))
        points.append((points[-1][0] + way * math.cos(heading), points[-1][1] + way * math.sin(heading)))
    if draw(st.booleans()):
        points += points[-2::-1]
    if draw(st.booleans()):
        points.insert(1, points[1])
    return points


@given(hairpins(), st.sampled_from([0.0, 0.03]))
@settings(max_examples=15, deadline=None)
def test_more_of_each_kind_is_asked_for_within_the_limits_only(points: Any, smoothing: Any) -> None:
    path = {"kind": "waypoints", "points": points, "speed": 0.1, "smoothing": smoothing}
    scenario = parse({"name": "more", "duration": 40, "path": path, "formation": {"shape": "triangle"}})
    feasibility = scenario.feasibility()
    assert asked(scenario).max() <= 1.1
    assert (feasibility.lag > 0.0) <= bool(feasibility.line)
    slots = scenario.reference(rounded=True).positions(np.arange(0.0, 40.0, 0.01))
    assert clearance(slots) == pytest.approx(scenario.spacing, rel=1e-9)
