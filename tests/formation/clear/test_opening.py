"""A change of shape opens the formation where bodies would come too near, and is as ever where they do not."""

from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from formation.clear.opening import CLOSE, ROOM, WIDEST, bump, opening
from formation.formation_spec import Formation
from formation.metrics import clearance, nearest
from formation.offsets import SHARE, Offsets, assignment
from formation.paths.kinds import Line
from formation.scenario.files import load
from formation.scenario.reshaping import change_of, reshaped
from formation.shapes import SHAPES

SPACING, SPEED = 0.1, 0.1
PATH = Line(kind="line", speed=SPEED)
ROUNDING = 2e-5
"""Of the least distance, because a change is looked at 201 times [m]."""


def changing(robots: int, first: Any, then: Any, **more: Any) -> Formation:
    change = {"at": 1.0, "offsets": np.asarray(then).tolist(), **more}
    return Formation.model_validate({"offsets": np.asarray(first).tolist(), "robots": robots, "changes": [change]})


@given(
    st.integers(2, 16),
    st.sampled_from(sorted(SHAPES)),
    st.sampled_from(sorted(SHAPES)),
    st.floats(0.01, 0.1),
    st.data(),
)
def test_between_any_two_shapes_bodies_keep_their_room(n: int, first: str, then: str, width: float, data: Any) -> None:
    try:
        places, others = SHAPES[first](n, SPACING), SHAPES[then](n, SPACING)
    except ValueError:
        assume(False)
    assume(len(places) == len(others) == n)
    order = data.draw(st.permutations(range(n)))
    offsets = Offsets(changing(n, places, others[order]), PATH, width)
    over = offsets.settled - 1.0
    t = 1.0 + np.linspace(0.0, over, 3001)
    found = offsets.at(t)
    kept = min(ROOM * width, CLOSE * min(nearest(found[0])[2], nearest(found[-1])[2]))
    assert clearance(found) >= kept - ROUNDING
    speed = np.linalg.norm(np.diff(found, axis=0), axis=-1).max() / (over / 3000)
    assert speed <= SHARE * SPEED * (1.0 + 2e-3)
    np.testing.assert_allclose(found[[0, -1]].mean(axis=1), 0.0, atol=1e-12)


@given(st.integers(3, 8), st.integers(0, 2**32))
def test_robots_that_take_any_places_keep_their_room_too(n: int, seed: int) -> None:
    """Unless they would meet: such a change is refused."""
    draws = np.random.default_rng(seed)
    cells = np.array([(x, y) for x in range(4) for y in range(4)]) * SPACING
    here, there = (cells[draws.permutation(16)[:n]] for _ in range(2))
    offsets = Offsets(changing(n, here, there, reassign=False, over=5.0), PATH, 0.07)
    opened = opening(here - here.mean(axis=0), there - there.mean(axis=0), list(range(n)), 0.07)
    assume(opened.by < WIDEST and not offsets.crowded())
    assert clearance(offsets.at(np.linspace(1.0, 6.0, 3001))) >= ROOM * 0.07 - 10 * ROUNDING


def test_without_need_nothing_opens() -> None:
    square, line = SHAPES["square"](4, SPACING), SHAPES["line"](4, SPACING)
    t = np.linspace(0.0, 20.0, 500)
    np.testing.assert_array_equal(
        Offsets(changing(4, square, line), PATH, 0.05).at(t), Offsets(changing(4, square, line), PATH).at(t)
    )


def test_a_wider_body_opens_more_and_takes_longer() -> None:
    square, line = SHAPES["square"](4, SPACING), SHAPES["line"](4, SPACING)
    line = line[assignment(square, line)]
    found = [opening(square, line, list(range(4)), width) for width in (0.05, 0.065, 0.07)]
    assert found[0].by == 0.0 < found[1].by < found[2].by
    assert found[0].peak <= found[1].peak <= found[2].peak


def test_some_robots_open_as_all_do() -> None:
    every = Offsets(changing(4, SHAPES["square"](4, SPACING), SHAPES["line"](4, SPACING)), PATH, 0.07)
    t = np.linspace(0.0, 20.0, 100)
    np.testing.assert_array_equal(every.rows([3, 2]).at(t), every.at(t)[:, [2, 1]])
    assert every.rows([3, 2]).every is every


def test_robots_that_have_no_place_in_the_shape_do_not_move() -> None:
    here = np.concatenate([SHAPES["square"](4, SPACING), [[1.0, 1.0]]])
    there = np.concatenate([SHAPES["line"](4, SPACING)[[1, 2, 0, 3]], [[1.0, 1.0]]])
    opened = opening(here, there, [0, 1, 2, 3], 0.07)
    assert opened.by > 0.0
    assert not opened.at(np.linspace(0.0, 1.0, 20))[:, 4].any()


def test_the_bump_has_no_jump_in_speed_or_acceleration() -> None:
    step = 1e-3
    values = bump(np.arange(-0.1, 1.1, step))
    assert values.max() == pytest.approx(1.0)
    assert np.abs(np.diff(values, 3)).max() < 500 * step**3


@pytest.mark.parametrize("name", ["follow-the-leader", "drive-me"])
def test_a_live_change_to_a_line_leaves_room_between_bodies(name: str) -> None:
    scenario = load(name)
    found = reshaped(scenario, [change_of(scenario, 5.0, shape="line")])
    assert clearance(found.offsets.at(np.linspace(5.0, 40.0, 4000))) > ROOM * 0.07 - ROUNDING
    assert found.offsets.reach >= np.hypot(*np.moveaxis(found.offsets.at(np.linspace(5, 40, 999)), -1, 0)).max() - 1e-6
