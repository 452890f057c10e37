"""Laws of a driven centre: it does what was ordered within its limits, and the slots can follow."""

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from formation.driving.going import THERE, towards
from formation.driving.law import REST, Order
from formation.errors import ScenarioError
from formation.scenario.files import load, parse
from formation.scenario.scenario import Scenario

RAW: dict[str, Any] = {"name": "t", "path": {"kind": "driven"}, "formation": {"shape": "square"}}
ORIENTATIONS = ["path", "limited", "fixed"]
orders = st.lists(st.tuples(st.integers(1, 300), st.floats(-1.0, 1.0), st.floats(-3.0, 3.0)), min_size=1, max_size=5)


def driven(orientation: str = "limited", **path: Any) -> Scenario:
    return parse({**RAW, "formation": {"shape": "square", "orientation": orientation}, "path": {**RAW["path"], **path}})


def test_a_centre_goes_where_its_order_leads() -> None:
    scenario = driven(acceleration=1000.0, turn_acceleration=1000.0)
    reference = scenario.driving()
    reference.order(0, Order(0.2, 0.0))
    reference.order(500, Order(0.2, math.pi / 10.0))
    straight, turned = reference.track.at(500), reference.track.at(1500)
    assert (straight.x, straight.y) == pytest.approx((1.0, 0.0), abs=2e-3)
    # Half a circle of radius 0.2 / (pi / 10).
    assert (turned.x - straight.x, turned.y - straight.y) == pytest.approx((0.0, 4.0 / math.pi), abs=5e-3)
    assert turned.theta == pytest.approx(math.pi, abs=0.01)


@settings(max_examples=25, deadline=None)
@given(orders, st.sampled_from(ORIENTATIONS))
def test_whatever_is_ordered_no_slot_is_faster_than_its_robot_or_jumps(given_orders: Any, orientation: str) -> None:
    scenario = driven(orientation)
    reference, law, k = scenario.driving(), scenario.law, 0
    for wait, v, omega in given_orders:
        reference.order(k, law.within(v, omega))
        k += wait
    t: Any = law.tick * np.arange(k + 200)
    slots = np.diff(reference.positions(t), axis=0)
    assert np.hypot(slots[..., 0], slots[..., 1]).max() <= scenario.robots.limits.v * law.tick
    rows = np.diff(reference.track.rows(np.rint(t / law.tick)), axis=0)
    assert np.hypot(rows[:, 1], rows[:, 2]).max() <= law.speed * law.tick * (1.0 + 1e-9)
    assert np.abs(rows[:, 3]).max() <= law.turn * law.tick * (1.0 + 1e-9)


@settings(max_examples=25, deadline=None)
@given(orders)
def test_an_order_changes_nothing_before_its_tick(given_orders: Any) -> None:
    law, k = driven().law, 0
    one, other = driven().driving(), driven().driving()
    for wait, v, omega in given_orders:
        one.order(k, law.within(v, omega))
        other.order(k, law.within(v, omega))
        one.track.at(k + 1000)  # looked ahead: what is ordered later must not depend on it
        k += wait
    ticks: Any = np.arange(0.0, k + 10.0)
    np.testing.assert_array_equal(one.track.rows(ticks), other.track.rows(ticks))


def test_an_order_cut_to_the_limits_is_within_them() -> None:
    law = driven().law
    assert law.within(*law.within(90.0, -90.0)) == law.within(90.0, -90.0) == Order(law.speed, -law.turn)


@settings(max_examples=30, deadline=None)
@given(st.floats(-1.5, 1.5), st.floats(-1.5, 1.5), st.sampled_from(ORIENTATIONS))
def test_the_centre_arrives_where_it_is_sent_and_stays(x: float, y: float, orientation: str) -> None:
    reference, law, k = driven(orientation).driving(), driven(orientation).law, 0
    while (order := towards(law, reference.track.at(k), x, y)) is not None:
        reference.order(k, order)
        k += 10
        assert k < 6000, reference.track.at(k)
    reference.order(k, REST)
    end, later = reference.track.at(k + 300), reference.track.at(k + 600)
    assert math.hypot(end.x - x, end.y - y) < (10.0 * THERE if orientation == "path" else 2.0 * THERE)
    assert end == later


@pytest.mark.parametrize(
    ("path", "words"),
    [
        ({"commands": [[1.0, 0.1, 0.0], [0.5, 0.1, 0.0]]}, ["path", "times in order"]),
        ({"commands": [[1.0, 1e9, 0.0]]}, ["path", "commands", "100"]),
        ({"known_to": "all"}, ["path", "known_to", "leader"]),
    ],
)
def test_a_driven_path_that_makes_no_sense_is_refused(path: Any, words: Any) -> None:
    with pytest.raises(ScenarioError) as caught:
        driven(**path)
    assert all(word in str(caught.value) for word in words), str(caught.value)


def test_a_controller_that_needs_the_path_cannot_be_driven() -> None:
    with pytest.raises(ScenarioError, match="virtual_structure needs the path"):
        parse({**RAW, "controller": {"name": "virtual_structure"}})


def test_a_wider_formation_is_driven_in_proportion() -> None:
    scenario = load("drive-me", {"bodies": {"preset": "turtlebot3"}, "path": {"commands": [[1.0, 0.1, 0.2]]}})
    (time, v, omega), by = scenario.path.commands[0], scenario.bodies.scaled  # type: ignore[union-attr]
    assert by > 1.0
    assert (time, v, omega) == pytest.approx((1.0, 0.1 * by, 0.2))
