"""The path's time against the clock: never ahead, never backwards, equal while every slot can be followed."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from formation.formation_spec import Formation
from formation.metrics import wrapped
from formation.offsets import Offsets
from formation.orientation import Along
from formation.paths.kinds import Circle, Figure8
from formation.paths.path import Path
from formation.schedule import MARGIN, Schedule
from formation.slot_motion import Course, Motion

FORMATION = Formation.model_validate({"shape": "triangle", "spacing": 0.2})
LIMITS = np.array([0.3, 1.0])
TICK = 0.01


def schedule(path: Path, limits: Any = LIMITS) -> tuple[Motion, Schedule]:
    motion = Motion(Course(path, Along(path, 0.1), 0.1), Offsets(FORMATION, path))
    return motion, Schedule(motion, limits, TICK)


@given(st.floats(0.3, 2.0), st.floats(0.05, 2.0))
@settings(max_examples=30, deadline=None)
def test_every_slot_keeps_the_limits_by_the_clock(radius: Any, rate: Any) -> None:
    motion, found = schedule(Circle(kind="circle", radius=radius, rate=rate))
    t = np.arange(0.0, 20.0, TICK)
    late = found.path_time(t)
    assert (np.diff(late) > 0.0).all()
    assert (np.diff(late) <= TICK * (1 + 1e-9)).all()
    # Within a step the chord of a slot's arc is a little shorter than its share: by less than one in ten thousand.
    moved = np.diff(motion.poses(late), axis=0)
    assert np.hypot(moved[..., 0], moved[..., 1]).max() <= MARGIN * LIMITS[0] * TICK * (1 + 1e-4)
    assert np.abs(wrapped(moved[..., 2])).max() <= MARGIN * LIMITS[1] * TICK * (1 + 1e-4)


def test_what_can_be_followed_keeps_the_clock_to_the_last_bit() -> None:
    _, found = schedule(Circle(kind="circle"))
    t = np.linspace(-3.0, 300.0, 1000)
    np.testing.assert_array_equal(found.path_time(t), t)
    assert found.lag(300.0) == 0.0


def test_it_slows_down_only_where_it_must() -> None:
    _, found = schedule(Figure8(kind="figure8", rate=0.16))
    pace = np.diff(found.path_time(np.arange(0.0, 60.0, TICK))) / TICK
    assert pace.min() < 0.95
    assert np.mean(pace > 1 - 1e-9) > 0.2
    assert 0.0 < found.lag(20.0) < found.lag(60.0)


@pytest.mark.parametrize("first", [3.0, 47.0])
def test_it_does_not_depend_on_what_was_asked_for_before(first: Any) -> None:
    path = Figure8(kind="figure8", rate=0.3)
    t = np.linspace(0.0, 80.0, 500)
    whole = schedule(path)[1].path_time(t)
    _, found = schedule(path)
    found.path_time(np.array([first]))
    np.testing.assert_array_equal(found.path_time(t), whole)


def test_before_the_start_nothing_is_late() -> None:
    _, found = schedule(Circle(kind="circle", rate=2.0))
    t = np.array([-5.0, -0.1, 0.0])
    found.path_time(np.array([30.0]))
    np.testing.assert_array_equal(found.path_time(t), t)
