"""Laws of the distances that a plan keeps from other bodies (docs/theory.md, section 19)."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from agents.kernels.nearby.separation import ASTRAY, COMES, HOLD, ORDERLY, ZONE, astray, caution, courses, met
from formation.arrays import FloatArray

SPACING, INTERVAL, TOUCH, KEEP = 0.1, 0.1, 0.07, 0.097
HEADINGS = np.linspace(0.0, 1.0, 21)
SHARES = st.floats(0.0, 1.0)


def body(x: float, y: float, vx: float = 0.0, vy: float = 0.0) -> FloatArray:
    return np.array([[x, y, vx, vy, TOUCH, KEEP]])


@given(st.floats(0.0, 0.3), st.floats(-math.pi, math.pi))
def test_a_robot_in_its_place_is_not_astray_and_one_far_from_it_is(away: float, where: float) -> None:
    slot = np.array([1.0, -2.0, 0.3])
    pose = slot + np.array([away * math.cos(where), away * math.sin(where), 1.0])
    found = astray(slot, pose, SPACING)
    assert 0.0 <= found <= 1.0
    if away < ORDERLY * SPACING - 1e-9:
        assert found == 0.0
    if away > ASTRAY * SPACING + 1e-9:
        assert found == 1.0


def test_who_is_in_its_place_keeps_no_distance_and_drives_as_ever() -> None:
    assert courses(body(0.08, 0.0), HEADINGS, 0.0, INTERVAL).shape == (1, 1, 3)  # nothing beyond the present
    assert caution(body(0.08, 0.0), np.zeros(3), 0.0) == 0.0


@given(SHARES, SHARES)
def test_the_farther_astray_the_farther_ahead_and_the_wider(one: float, other: float) -> None:
    less, more = (courses(body(0.1, 0.0), HEADINGS, far, INTERVAL) for far in sorted((one, other)))
    assert less.shape[1] <= more.shape[1]
    assert TOUCH < less[0, 0, 2] <= more[0, 0, 2] <= KEEP


def test_a_body_goes_on_as_the_formation_turns_and_then_stands() -> None:
    speed = 0.2
    found = courses(body(0.0, 0.0, speed), HEADINGS, 1.0, INTERVAL)[0]
    steps = np.diff(found[:, :2], axis=0)
    held = round(HOLD / INTERVAL)
    np.testing.assert_allclose(np.hypot(*steps[:held].T), speed * INTERVAL)
    np.testing.assert_allclose(np.arctan2(steps[:held, 1], steps[:held, 0]), HEADINGS[:held], atol=1e-12)
    assert not steps[held:].any()


@pytest.mark.parametrize("far", [0.3, 1.0])
def test_the_nearer_a_body_the_gentler(far: float) -> None:
    cautions = [caution(body(TOUCH + gap, 0.0), np.zeros(3), far) for gap in (0.2, 0.1, 0.05, 0.02, 0.0)]
    assert cautions == sorted(cautions)
    assert cautions[0] == 0.0
    assert cautions[-1] > cautions[-2]
    assert caution(np.zeros((0, 6)), np.zeros(3), far) == 0.0


@given(st.floats(0.0, 0.3))
def test_a_robot_in_its_place_heeds_who_comes_and_not_who_drives_along(speed: float) -> None:
    ahead, pose = TOUCH + 0.5 * ZONE, np.zeros(3)
    assert met(body(ahead, 0.0, speed), pose, speed) == 0.0
    assert met(body(TOUCH + 2.0 * ZONE, 0.0), pose, speed) == 0.0
    found = met(body(ahead, 0.0), pose, speed)
    assert found == pytest.approx(min(max(speed / COMES - 1.0, 0.0), 1.0))
    assert met(body(ahead, 0.0, -speed), pose, 0.0) == pytest.approx(found)
