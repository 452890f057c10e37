"""Formations that change: exact before and after, smooth between, never crowded, never backwards."""

# mypy: disable-error-code="arg-type, call-arg"
# (numpy scalars and shapes; what strict typing of numpy makes of test arithmetic)

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import linear_sum_assignment

from formation.errors import ScenarioError
from formation.formation_spec import Formation
from formation.metrics import clearance
from formation.offsets import SHARE, Offsets, assignment
from formation.paths.kinds import Circle, Line
from formation.scenario.files import load
from formation.shapes import SHAPES

PATH = Circle(kind="circle")
PAIRS = [("triangle", "line", 3), ("square", "column", 4), ("polygon", "wedge", 7), ("line", "polygon", 6)]


def formation(first: str, then: str, robots: int, **change: Any) -> Formation:
    return Formation.model_validate(
        {"shape": first, "robots": robots, "changes": [{"at": 5.0, "shape": then, "robots": robots, **change}]}
    )


@pytest.mark.parametrize(("first", "then", "robots"), PAIRS)
def test_a_change_leads_from_one_shape_to_the_other(first: Any, then: Any, robots: Any) -> None:
    offsets = Offsets(formation(first, then, robots, over=4.0), PATH)
    before, after = offsets.at(np.array([0.0, 5.0])), offsets.at(np.array([9.0, 100.0]))
    np.testing.assert_allclose(before, [SHAPES[first](robots, 0.1)] * 2, atol=1e-15)
    wanted = SHAPES[then](robots, 0.1)
    for places in after:
        gaps = np.linalg.norm(places[:, None] - wanted[None], axis=-1)
        assert sorted(gaps.argmin(axis=1)) == list(range(robots))  # every slot is taken by one robot
        assert gaps.min(axis=1).max() < 1e-12
    np.testing.assert_allclose(offsets.at(np.linspace(0, 10, 50)).mean(axis=1), 0.0, atol=1e-12)


@pytest.mark.parametrize(("first", "then", "robots"), PAIRS)
def test_robots_keep_their_distance_while_they_change_places(first: Any, then: Any, robots: Any) -> None:
    offsets = Offsets(formation(first, then, robots, over=4.0), PATH)
    assert clearance(offsets.at(np.linspace(4.9, 9.1, 500))) > 0.1 / math.sqrt(2.0) - 1e-9


@given(st.integers(0, 2**32))
def test_random_shapes_spaced_by_d_never_come_closer_than_d_over_root_two(seed: Any) -> None:
    generator = np.random.default_rng(seed)
    robots = int(generator.integers(2, 8))
    cells = [(x, y) for x in range(4) for y in range(4)]
    two = [[cells[j] for j in generator.permutation(16)[:robots]] for _ in range(2)]
    changing = {"offsets": two[0], "changes": [{"at": 0.0, "over": 1.0, "offsets": two[1]}]}
    offsets = Offsets(Formation.model_validate(changing), PATH)
    assert clearance(offsets.at(np.linspace(0.0, 1.0, 101))) > 1.0 / math.sqrt(2.0) - 1e-9


@given(st.integers(1, 12), st.integers(0, 10_000), st.booleans())
def test_the_assignment_is_the_best_one_and_of_equal_ones_the_same_as_ever(n: int, seed: int, even: bool) -> None:
    draws = np.random.default_rng(seed)
    here, there = (draws.integers(0, 3, (n, 2)) * 0.1 if even else draws.normal(size=(n, 2)) for _ in range(2))
    cost = ((here[:, None] - there[None]) ** 2).sum(axis=-1)
    assert assignment(here, there) == list(linear_sum_assignment(cost)[1])


def test_without_reassignment_row_i_is_robot_i() -> None:
    offsets = Offsets(formation("line", "column", 3, reassign=False, over=1.0), PATH)
    np.testing.assert_allclose(offsets.at(np.array([6.0]))[0], SHAPES["column"](3, 0.1), atol=1e-15)


def test_velocity_and_acceleration_are_continuous() -> None:
    offsets = Offsets(formation("triangle", "line", 3, over=2.0), PATH)
    step = 1e-3
    places = offsets.at(np.arange(4.5, 7.5, step))
    jerk_free = np.diff(places, 2, axis=0) / step**2
    assert np.abs(np.diff(jerk_free, axis=0)).max() < 0.01  # m/s^2 from one millisecond to the next
    assert np.abs(jerk_free).max() > 0.05


@pytest.mark.parametrize("speed", [0.02, 0.1, 1.0])
def test_a_derived_duration_keeps_every_slot_slower_than_its_share_of_the_path(speed: Any) -> None:
    offsets = Offsets(formation("triangle", "line", 3), Line(kind="line", speed=speed))
    step = 1e-3
    velocity = np.diff(offsets.at(np.arange(4.0, 40.0, step)), axis=0) / step
    fastest = np.linalg.norm(velocity, axis=-1).max()
    assert fastest <= SHARE * speed * (1 + 1e-3)
    assert fastest > 0.9 * SHARE * speed or speed == 1.0  # never shorter than a second


def test_the_spacing_can_change_too() -> None:
    scenario = load("triangle-circle", ["formation.changes=[{at=1, over=2, shape='triangle', spacing=0.2}]"])
    places = scenario.reference().positions(np.array([0.5, 4.0]))
    sides = np.linalg.norm(places - np.roll(places, 1, axis=1), axis=-1)
    np.testing.assert_allclose(sides, [[0.1] * 3, [0.2] * 3], atol=1e-12)


def test_some_robots_see_what_all_see() -> None:
    every = Offsets(formation("square", "column", 4), PATH)
    t = np.linspace(0.0, 20.0, 30)
    np.testing.assert_array_equal(every.rows([3, 2]).at(t), every.at(t)[:, [2, 1]])


@pytest.mark.parametrize(
    ("entry", "words"),
    [
        ("{at=1, shape='square'}", ["changes[0]", "3 robots", "4"]),
        ("{at=1}", ["either shape or offsets"]),
        ("{at=1, shape='line', over=0}", ["over"]),
        ("{at=1, offsets=[[0, 0], [0, 0], [1, 1]]}", ["changes[0]", "differ"]),
        ("{at=3, shape='line'}, {at=1, shape='triangle'}", ["order"]),
    ],
)
def test_a_wrong_change_is_named(entry: Any, words: Any) -> None:
    with pytest.raises(ScenarioError) as caught:
        load("triangle-circle", [f"formation.changes=[{entry}]"])
    assert all(word in str(caught.value) for word in words), str(caught.value)
