"""Laws of the motion of one robot: it is what a fine integration gives, it composes, and it can be undone."""

# mypy: disable-error-code="call-arg"
# (unpacked poses, numpy scalars and shapes; what strict typing of numpy makes of test arithmetic)

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from formation.unicycle import SMALL_TURN, roll_out, step, wrap

POSE = st.tuples(st.floats(-5, 5), st.floats(-5, 5), st.floats(-4, 4))
V = st.floats(-0.5, 0.5)
OMEGA = st.floats(-2, 2) | st.floats(-1e-3, 1e-3) | st.just(0.0)
TIME = st.floats(0.0, 0.5)
EXACT = 1e-12
"""Rounding of a few operations on numbers of size 5, with room."""


def near(a: tuple[float, ...], b: tuple[float, ...], tolerance: float = EXACT) -> bool:
    return all(abs(p - q) <= tolerance for p, q in zip(a, b, strict=True))


def fine(x: float, y: float, theta: float, v: float, omega: float, dt: float, pieces: int) -> tuple[float, float]:
    """Euler's rule, with the heading in the middle of every piece."""
    h = dt / pieces
    for n in range(pieces):
        middle = theta + omega * h * (n + 0.5)
        x, y = x + v * h * math.cos(middle), y + v * h * math.sin(middle)
    return x, y


@given(POSE, V, OMEGA, TIME)
def test_a_step_is_what_a_fine_euler_integration_gives(pose: Any, v: Any, omega: Any, dt: Any) -> None:
    x, y, theta = step(*pose, v, omega, dt)
    # The midpoint rule's error is v omega^2 dt h^2 / 24: with 200 pieces at most 0.5 * 4 * 0.5 * 0.0025^2 / 24.
    assert near((x, y), fine(*pose, v, omega, dt, 200), 3e-7)
    assert theta == pytest.approx(pose[2] + omega * dt, abs=EXACT)


def test_plain_euler_of_eq_1_converges_to_a_step() -> None:
    x, y, theta = 0.0, 0.0, 0.3
    gaps = []
    for pieces in (100, 1000, 10_000):
        x, y, theta = 0.0, 0.0, 0.3
        for _ in range(pieces):
            h = 0.5 / pieces
            x, y, theta = x + h * math.cos(theta) * 0.5, y + h * math.sin(theta) * 0.5, theta + h * 2.0
        gaps.append(math.dist((x, y), step(0.0, 0.0, 0.3, 0.5, 2.0, 0.5)[:2]))
    assert gaps[0] / gaps[1] == pytest.approx(10, rel=0.02)  # a rule of first order, towards zero
    assert gaps[1] / gaps[2] == pytest.approx(10, rel=0.02)


@given(POSE, V, OMEGA, TIME, TIME)
def test_a_step_and_then_a_step_is_the_step_of_the_sum(pose: Any, v: Any, omega: Any, first: Any, second: Any) -> None:
    assert near(step(*step(*pose, v, omega, first), v, omega, second), step(*pose, v, omega, first + second))


@given(POSE, V, OMEGA, TIME)
def test_negative_inputs_lead_back(pose: Any, v: Any, omega: Any, dt: Any) -> None:
    assert near(step(*step(*pose, v, omega, dt), -v, -omega, dt), pose)


@given(POSE, V, OMEGA, TIME)
def test_negative_time_leads_back(pose: Any, v: Any, omega: Any, dt: Any) -> None:
    assert near(step(*step(*pose, v, omega, dt), v, omega, -dt), pose)


@given(POSE, V, OMEGA)
def test_no_time_changes_nothing(pose: Any, v: Any, omega: Any) -> None:
    assert step(*pose, v, omega, 0.0) == pose


@given(POSE, V, OMEGA, TIME, st.floats(-3, 3), st.floats(-2, 2), st.floats(-2, 2))
def test_a_step_turns_and_moves_with_the_scene(
    pose: Any, v: Any, omega: Any, dt: Any, angle: Any, dx: Any, dy: Any
) -> None:
    def moved(p: tuple[float, float, float]) -> tuple[float, float, float]:
        c, s = math.cos(angle), math.sin(angle)
        return c * p[0] - s * p[1] + dx, s * p[0] + c * p[1] + dy, p[2] + angle

    assert near(step(*moved(pose), v, omega, dt), moved(step(*pose, v, omega, dt)), 1e-11)


@given(st.floats(0.1, 2), st.floats(-2, 2).filter(lambda w: abs(w) > 0.05))
def test_a_full_turn_closes_a_circle_of_radius_v_over_omega(v: Any, omega: Any) -> None:
    time = 2 * math.pi / abs(omega)
    assert near(step(0, 0, 0, v, omega, time)[:2], (0, 0), 1e-9)
    half = step(0, 0, 0, v, omega, time / 2)
    assert near(half[:2], (0, 2 * v / omega), 1e-9)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_the_step_is_continuous_where_the_series_begins(sign: Any) -> None:
    omega = sign * 2 * SMALL_TURN  # with dt = 1: half a turn of SMALL_TURN
    below, above = (step(0, 0, 0.3, 0.5, omega * factor, 1.0) for factor in (1 - 1e-9, 1 + 1e-9))
    assert near(below, above, 1e-12)
    series, formula = 1 - SMALL_TURN**2 / 6, math.sin(SMALL_TURN) / SMALL_TURN
    assert abs(series - formula) < 1e-15


@given(st.floats(-100, 100))
def test_a_wrapped_angle_is_the_same_angle_within_half_a_turn(angle: Any) -> None:
    wrapped = wrap(angle)
    assert -math.pi <= wrapped <= math.pi
    assert math.cos(wrapped) == pytest.approx(math.cos(angle), abs=1e-12)
    assert math.sin(wrapped) == pytest.approx(math.sin(angle), abs=1e-12)


@given(st.floats(-math.pi + 1e-9, math.pi - 1e-9), st.integers(-5, 5))
def test_wrapping_takes_whole_turns_away(angle: Any, turns: Any) -> None:
    assert wrap(angle + 2 * math.pi * turns) == pytest.approx(angle, abs=1e-13)


@given(
    st.lists(st.tuples(st.floats(-0.5, 0.5), st.floats(-2.0, 2.0) | st.floats(-3e-3, 3e-3)), min_size=1, max_size=20),
    st.tuples(st.floats(-5.0, 5.0), st.floats(-5.0, 5.0), st.floats(-3.0, 3.0)),
)
def test_a_roll_out_is_step_after_step(inputs: list[tuple[float, float]], start: tuple[float, float, float]) -> None:
    rolled = roll_out(np.array([start]), np.array([inputs]), 0.1)[0]
    pose = start
    assert rolled[0].tolist() == list(start)
    for row, (v, omega) in enumerate(inputs, start=1):
        pose = step(*pose, v, omega, 0.1)
        np.testing.assert_allclose(rolled[row], pose, atol=1e-12)
