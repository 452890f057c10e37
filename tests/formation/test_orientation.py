"""Which way a formation faces: as the path, as it is told, or as fast as it may turn."""

# mypy: disable-error-code="arg-type, call-arg"
# (numpy scalars and shapes; what strict typing of numpy makes of test arithmetic)

import math
from typing import Any

import numpy as np
import pytest

from formation.metrics import wrapped
from formation.orientation import SHARE, SMOOTHING, Along, Fixed, Limited, Rounded
from formation.paths.kinds import Circle, Corner, Figure8
from formation.paths.path import heading
from formation.scenario.files import load

CORNER, CIRCLE, EIGHT = Corner(kind="corner", at=5.0), Circle(kind="circle"), Figure8(kind="figure8")
STEP = 1e-3


def rates(angles: Any) -> Any:
    return wrapped(np.diff(angles)) / STEP


@pytest.mark.parametrize("path", [CORNER, EIGHT])
@pytest.mark.parametrize("rate", [0.02, 0.3])
def test_a_limited_formation_never_turns_faster_than_its_limit(path: Any, rate: Any) -> None:
    turning = rates(Limited(path, 0.1, rate=rate, reach=0.1).angle(np.arange(0.0, 40.0, STEP)))
    assert np.abs(turning).max() <= rate * (1 + 1e-6)
    assert np.abs(turning).max() > 0.9 * rate or path is EIGHT


def test_a_limited_formations_rate_has_no_jumps() -> None:
    turning = rates(Limited(CORNER, 0.1, rate=0.3, reach=0.1).angle(np.arange(3.0, 12.0, STEP)))
    assert np.abs(np.diff(turning)).max() <= 2.0 * 0.3 * STEP / SMOOTHING + 1e-9


def test_a_limited_formation_follows_a_path_that_turns_slowly() -> None:
    t = np.arange(0.0, 100.0, 0.1)
    gap = wrapped(Limited(CIRCLE, 0.1, rate=0.2, reach=0.1).angle(t) - heading(CIRCLE, t, 0.1))
    assert np.abs(gap).max() < 1e-4  # what the grid leaves; the average of a straight line is the line
    late = wrapped(Limited(CORNER, 0.1, rate=0.3, reach=0.1).angle(np.array([20.0])) - math.pi / 4)
    assert abs(late[0]) < 1e-9


def test_a_limited_orientation_does_not_depend_on_what_was_asked_before() -> None:
    t = np.arange(0.0, 60.0, 0.25)
    whole = Limited(EIGHT, 0.1, rate=0.05, reach=0.1).angle(t)
    piecewise = Limited(EIGHT, 0.1, rate=0.05, reach=0.1)
    pieces = [piecewise.angle(t[j : j + 30]) for j in range(0, len(t), 30)]
    np.testing.assert_array_equal(np.concatenate(pieces), whole)
    again = piecewise.angle(t[:30])
    np.testing.assert_array_equal(again, whole[:30])


@pytest.mark.parametrize("reach", [0.05, 0.5])
def test_rotation_moves_no_slot_faster_than_its_share_of_the_path(reach: Any) -> None:
    t = np.arange(-10.0, 40.0, STEP)
    for orientation in (Rounded(CORNER, 0.1, reach=reach), Limited(CORNER, 0.1, rate=None, reach=reach)):
        fastest = np.abs(rates(orientation.angle(t))).max() * reach
        assert 0.8 * SHARE * 0.1 < fastest <= SHARE * 0.1 * math.sqrt(2.0) + 1e-9


def test_a_rounded_corner_is_the_path_before_and_after_and_half_turned_at_the_corner() -> None:
    rounded = Rounded(CORNER, 0.1, reach=0.05)
    away = np.array([0.0, 1.0, 12.0, 30.0])
    np.testing.assert_allclose(rounded.angle(away), heading(CORNER, away, 0.1), atol=1e-12)
    assert rounded.angle(np.array([5.0]))[0] == pytest.approx(math.pi / 2 - math.pi / 8)


def test_only_corners_are_rounded() -> None:
    t = np.linspace(0.0, 50.0, 99)
    np.testing.assert_array_equal(Rounded(EIGHT, 0.1, reach=0.1).angle(t), Along(EIGHT, 0.1).angle(t))
    scenario = load("triangle-corner")
    corner = scenario.path.corners[0][0]
    there = np.array([corner - 0.05, corner + 0.15])
    jumped, rounded = (scenario.reference(rounded=choice).positions(there) for choice in (False, True))
    turned = np.diff(np.arctan2(*(jumped - jumped.mean(axis=1, keepdims=True))[:, 0].T))
    assert abs(turned[0]) == pytest.approx(math.pi / 4, abs=1e-6)
    turned = np.diff(np.arctan2(*(rounded - rounded.mean(axis=1, keepdims=True))[:, 0].T))
    assert abs(turned[0]) < 0.12


def test_in_a_fixed_formation_every_slot_moves_as_the_centre() -> None:
    np.testing.assert_array_equal(Fixed(0.3).angle(np.arange(4.0)), [0.3] * 4)
    settings = ["formation.orientation=fixed", "formation.heading=1.0"]
    block = load("square-figure8", settings).reference().block(0)
    moved = block.slots[100, :, :2] - block.slots[0, :, :2]
    np.testing.assert_allclose(moved, [block.centre[100, :2] - block.centre[0, :2]] * 4, atol=1e-12)
    np.testing.assert_allclose(np.ptp(block.inputs[:1000], axis=1), 0.0, atol=1e-9)


@pytest.mark.parametrize("orientation", ["path", "limited"])
@pytest.mark.parametrize("at", [20.0, 33.7])
def test_a_wider_shape_alters_nothing_before_it_is_taken_and_nothing_jumps(orientation: Any, at: float) -> None:
    """The square can turn as the figure 8 does, the line cannot."""
    formation = {"shape": "square", "orientation": orientation}
    change = {"at": at, "shape": "line", "spacing": 0.1}
    plain, changed = (
        load("square-figure8", {"formation": {**formation, "changes": changes}}).reference()
        for changes in ([], [change])
    )
    k = round(at / 0.01)
    for tick in (1, k // 2, k - 200):
        np.testing.assert_array_equal(changed.block(tick).slots[:2], plain.block(tick).slots[:2])
    places = np.array(
        [block.slots[row - block.first] for row, block in ((i, changed.block(i)) for i in range(k - 50, k + 900))]
    )
    moved = np.hypot(*np.moveaxis(np.diff(places[..., :2], axis=0), -1, 0)) / 0.01
    assert np.abs(np.diff(moved, axis=0)).max() < 0.01
