"""Feasible references: every slot is where the offsets say, and its inputs take it there."""

# mypy: disable-error-code="arg-type, call-arg"
# (unpacked poses, numpy scalars and shapes; what strict typing of numpy makes of test arithmetic)

import math
from typing import Any

import numpy as np
import pytest

from formation.metrics import pattern_errors, wrapped
from formation.pattern import rotate
from formation.reference import BEHIND_TICKS, BLOCK_TICKS, HORIZONS, Block, Reference
from formation.scenario.files import load
from formation.scenario.scenario import Scenario
from formation.unicycle import step

SMOOTH = ["circle", "sinusoid", "figure8", "triangle-circle", "hexagon-sinusoid", "ring-16"]


def table(name: str, *settings: str) -> tuple[Scenario, Block]:
    scenario = load(name, settings)
    return scenario, scenario.reference().block(0)


@pytest.mark.parametrize("name", SMOOTH)
def test_an_input_takes_a_slot_to_its_next_pose_within_a_micrometre(name: Any) -> None:
    scenario, block = table(name)
    dt, stride = scenario.controller.prediction_interval, scenario.stride
    checked = 0
    for row in range(0, BLOCK_TICKS, 25):
        for i in range(scenario.size):
            pose, (v, omega) = block.slots[row, i], block.inputs[row, i]
            x, y, theta = step(*pose, v, omega, dt)
            target = block.slots[row + stride, i]
            assert math.hypot(x - target[0], y - target[1]) < 1e-6
            assert abs(math.remainder(theta - target[2], 2 * math.pi)) < 1e-9
            checked += 1
    assert checked == BLOCK_TICKS // 25 * scenario.size


def test_a_slot_on_a_circle_is_followed_over_a_whole_horizon() -> None:
    scenario, block = table("circle")
    for row in (0, 700):
        x, y, theta = block.slots[row, 0]
        for j in range(scenario.controller.horizon):
            x, y, theta = step(x, y, theta, *block.inputs[row + j * scenario.stride, 0], 0.1)
        target = block.slots[row + scenario.controller.horizon * scenario.stride, 0]
        # An arc is exact on a circle. What is left: SLOW bends the slot's heading by (1 mm/s / 42 mm/s)^2 of its
        # 2.5 mrad against the sampled path's, 1.4 microrad, over 85 mm.
        assert math.hypot(x - target[0], y - target[1]) < 2e-7


@pytest.mark.parametrize("name", [*SMOOTH, "spiral", "square-figure8", "triangle-corner"])
def test_all_pattern_errors_are_zero_when_every_robot_is_in_its_slot(name: Any) -> None:
    scenario, block = table(name)
    placed = rotate(block.centre[:, None, 2], scenario.formation.array)
    distance, angle = pattern_errors(block.slots, placed)
    assert np.abs(distance).max() < 1e-12
    assert np.abs(angle).max() < 1e-10
    np.testing.assert_allclose(block.slots[..., :2].mean(axis=1), block.centre[:, :2], atol=1e-12)


@pytest.mark.parametrize("name", SMOOTH)
def test_a_slot_points_where_it_goes(name: Any) -> None:
    _, block = table(name)
    t = slice(1, 1500)
    velocity = (block.slots[2:1501, :, :2] - block.slots[:1499, :, :2]) / 0.02
    theta = block.slots[t, :, 2]
    across = -np.sin(theta) * velocity[..., 0] + np.cos(theta) * velocity[..., 1]
    along = np.cos(theta) * velocity[..., 0] + np.sin(theta) * velocity[..., 1]
    assert np.abs(along).min() > 5e-3
    # SLOW = 1 mm/s bends the heading by (SLOW / v)^2: at 1 cm/s by a per cent of the sideways speed.
    assert np.abs(across / along).max() < 0.02
    assert np.median(np.abs(across / along)) < 1e-3


def test_the_centre_is_sampled_over_a_prediction_interval_as_in_the_paper() -> None:
    """On a circle in closed form: the heading is that of the chord of the last interval, the speed that of the next."""
    radius, rate, interval = 0.8, 0.05, 0.1
    _, block = table("circle", f"path.radius={radius}", f"path.rate={rate}")
    t = np.arange(500) * 0.01
    centre = block.centre[:500]
    np.testing.assert_allclose(centre[:, :2], radius * np.stack([np.cos(rate * t), np.sin(rate * t)], 1), atol=1e-12)
    heading_of_chord = rate * (t - interval / 2) + math.pi / 2
    np.testing.assert_allclose(wrapped(centre[:, 2] - heading_of_chord), 0.0, atol=1e-9)
    np.testing.assert_allclose(centre[:, 3], 2 * radius * math.sin(rate * interval / 2) / interval, atol=1e-9)
    np.testing.assert_allclose(centre[:, 4], rate, atol=1e-7)


def test_slots_stand_at_the_offsets_turned_by_the_paths_heading() -> None:
    scenario, block = table("hexagon-sinusoid")
    expected = block.centre[:, None, :2] + rotate(block.centre[:, 2][:, None], scenario.formation.array)
    np.testing.assert_allclose(block.slots[..., :2], expected, atol=1e-12)


def test_the_outer_robot_goes_faster_and_the_inner_slower() -> None:
    scenario, block = table("circle")  # 0.8 m at 0.05 rad/s, counter-clockwise: robot 1 stands right, outside
    outer, inner = block.inputs[100, :, 0]
    assert outer == pytest.approx(0.05 * 0.85, rel=1e-3)
    assert inner == pytest.approx(0.05 * 0.75, rel=1e-3)
    np.testing.assert_allclose(block.inputs[100, :, 1], 0.05, rtol=1e-6)
    assert scenario.formation.array[0, 1] < 0


def test_a_slot_inside_a_tight_turn_goes_backwards_with_its_heading_ahead() -> None:
    scenario, block = table("circle", "path.radius=0.05", "formation.spacing=0.3")  # the inner offset is 0.15 m
    outer, inner = block.inputs[100, :, 0]
    assert outer == pytest.approx(0.05 * 0.2, rel=0.02)
    assert inner == pytest.approx(-0.05 * 0.1, rel=0.06)
    drift = wrapped(block.slots[..., 2] - block.centre[:, 2][:, None])
    assert np.abs(drift).max() < math.pi / 2
    assert scenario.size == 2


@pytest.mark.parametrize("name", ["circle", "triangle-corner", "ring-16"])
def test_a_row_does_not_depend_on_the_block_it_stands_in(name: Any) -> None:
    scenario = load(name)
    first, second = scenario.reference().block(0), scenario.reference().block(BLOCK_TICKS)
    assert (first.first, second.first) == (0, BLOCK_TICKS - BEHIND_TICKS)
    both = BEHIND_TICKS + HORIZONS * scenario.stride * scenario.controller.horizon + 1
    for table in ("centre", "slots", "inputs"):
        a, b = getattr(first, table)[second.first :], getattr(second, table)[:both]
        assert len(a) == len(b) == both
        # Times are multiples of the same tick in both: equal to the last bit.
        np.testing.assert_array_equal(a, b)


def test_a_block_holds_every_tick_to_the_end_of_the_horizon() -> None:
    scenario = load("figure8")
    reference = scenario.reference()
    for k in (0, 1, BLOCK_TICKS - 1, BLOCK_TICKS, 5 * BLOCK_TICKS + 77):
        block = reference.block(k)
        assert block.first <= k
        assert k - block.first + scenario.stride * scenario.controller.horizon < len(block.slots)
        assert len(block.slots) == len(block.inputs) == len(block.centre)


def test_a_block_is_made_once() -> None:
    reference = load("figure8").reference()
    assert reference.block(3) is reference.block(BLOCK_TICKS - 1)
    assert reference.block(3) is not reference.block(BLOCK_TICKS)


def test_the_reference_of_some_robots_has_their_columns() -> None:
    scenario = load("hexagon-sinusoid")
    whole, some = scenario.reference().block(0), scenario.reference([5, 4]).block(0)
    np.testing.assert_array_equal(some.slots, whole.slots[:, [4, 3]])
    np.testing.assert_array_equal(some.inputs, whole.inputs[:, [4, 3]])
    np.testing.assert_array_equal(some.centre, whole.centre)


@pytest.mark.parametrize("name", ["ring-16", "hexagon-sinusoid", "triangle-corner"])
def test_a_robots_reference_has_the_same_bits_whether_that_of_all_was_made_before_or_not(name: str) -> None:
    one, other = load(name), load(name)
    whole = one.reference(rounded=True)
    of_all, alone = (of.reference([1, one.size, 2], rounded=True) for of in (one, other))
    for k in (0, BLOCK_TICKS):
        assert of_all.block(k).slots.tobytes() == alone.block(k).slots.tobytes()
        assert of_all.block(k).inputs.tobytes() == alone.block(k).inputs.tobytes()
        assert of_all.block(k).centre is whole.block(k).centre  # it was taken from there


def test_other_intervals_are_obeyed() -> None:
    scenario = load("circle", ["control_interval=0.02", "controller.prediction_interval=0.2", "controller.horizon=5"])
    assert isinstance(scenario.reference(), Reference)
    block = scenario.reference().block(0)
    v, omega = block.inputs[0, 0]
    x, y, theta = step(*block.slots[0, 0], v, omega, 0.2)
    assert block.slots[10, 0] == pytest.approx([x, y, theta], abs=1e-6)
    assert len(block.slots) == BLOCK_TICKS + HORIZONS * 50 + 1
