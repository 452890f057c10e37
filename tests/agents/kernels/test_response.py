"""Laws of the best response (docs/theory.md, section 14): its cost, and what one step does to it."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from agents.kernels.response import Lag, Stage, Targets, lag_of, respond
from formation.arrays import FloatArray
from formation.unicycle import step

STEPS, DT, SPACING = 12, 0.1, 0.1
WIDE = np.array([50.0, 50.0])
SEEDS = st.integers(0, 2**32)
LAGS = st.sampled_from([0.0, 0.1, 0.3])


def problem(seed: int) -> tuple[FloatArray, Targets, Stage]:
    """A robot near its slot on an arc, with two neighbours that are a little off theirs, and a body in the way."""
    source = np.random.default_rng(seed)
    inputs = np.tile([0.1, 0.3], (STEPS, 1))
    slots = np.zeros((STEPS + 1, 3))
    for j in range(STEPS):
        x, y, theta = slots[j].tolist()
        slots[j + 1] = step(x, y, theta, 0.1, 0.3, DT)
    angles = source.uniform(-np.pi, np.pi, 2)
    direction = np.stack([np.tile([np.cos(a), np.sin(a)], (STEPS + 1, 1)) for a in angles])
    error = 0.01 * source.standard_normal((2, STEPS + 1))
    body = slots[: STEPS // 2] + np.append(source.normal(0.0, 0.02, 2), 0.0)
    body[:, 2] = source.uniform(0.0, 0.03)
    targets = Targets(slots, inputs, direction, error, 0.003 * source.standard_normal(2), body[None])
    costs, room = np.array([1.0, 0.4]), 150.0 / SPACING**2
    stage = Stage(60.0 / SPACING**2, np.array([100.0, 50.0]) / SPACING**2, 1.0, costs, WIDE, room)
    start = np.concatenate([slots[0] + source.normal(0.0, [0.01, 0.01, 0.1]), [0.1, 0.3]])
    return start, targets, stage


def solved(
    start: FloatArray, nominal: FloatArray, targets: Targets, stage: Stage, lag: Lag
) -> tuple[float, FloatArray]:
    out = np.empty_like(nominal)
    change = respond(start, nominal, targets, stage, lag, DT, np.empty((STEPS + 1, 24)), out, np.empty_like(nominal))
    return change, out


def cost(start: FloatArray, inputs: FloatArray, targets: Targets, stage: Stage, lag: Lag) -> float:
    """J of these inputs, by the text of section 14."""
    x, y, theta, v, w = start.tolist()
    total = 0.0
    for j, c in enumerate(inputs):
        total += 0.5 * float(stage.inputs @ (c - targets.inputs[j]) ** 2)
        mean = [(1.0 - lag.blend) * c[i] + lag.blend * (v, w)[i] for i in range(2)]
        x, y, theta = step(x, y, theta, mean[0], mean[1], DT)
        x, y = x + DT * targets.drift[0], y + DT * targets.drift[1]
        v, w = ((1.0 - lag.keep) * c[i] + lag.keep * (v, w)[i] for i in range(2))
        e = targets.slots[j + 1] - [x, y, theta]
        along = np.array([d[j + 1] @ e[:2] for d in targets.direction]) - targets.error[:, j + 1]
        for body in targets.bodies[:, j + 1 : j + 2, :].reshape(-1, 3):
            total += 0.5 * stage.room * max(float(body[2] - np.hypot(*(body[:2] - [x, y]))), 0.0) ** 2
        total += 0.5 * (stage.place * float(e[:2] @ e[:2]) + float(stage.edge @ along**2) + stage.heading * e[2] ** 2)
    return total


@given(seed=SEEDS, tau=LAGS)
def test_a_step_lowers_the_cost(seed: int, tau: float) -> None:
    start, targets, stage = problem(seed)
    _, out = solved(start, targets.inputs, targets, stage, lag_of(tau, DT))
    assert cost(start, out, targets, stage, lag_of(tau, DT)) < cost(
        start, targets.inputs, targets, stage, lag_of(tau, DT)
    )


@given(seed=SEEDS, tau=LAGS)
@settings(max_examples=20)
def test_a_step_from_the_optimum_changes_nothing_and_no_input_alone_improves_it(seed: int, tau: float) -> None:
    start, targets, stage = problem(seed)
    lag = lag_of(tau, DT)
    inputs, change = targets.inputs, np.inf
    for _ in range(60):
        change, inputs = solved(start, inputs, targets, stage, lag)
    assert change < 1e-8
    best = cost(start, inputs, targets, stage, lag)
    source = np.random.default_rng(seed)
    for _ in range(10):
        other = inputs + 1e-4 * source.standard_normal(inputs.shape)
        assert cost(start, other, targets, stage, lag) > best


@given(seed=SEEDS)
def test_inputs_are_within_the_limits(seed: int) -> None:
    start, targets, stage = problem(seed)
    limits = np.array([0.11, 0.35])
    _, out = solved(start, targets.inputs, targets, stage._replace(limits=limits), lag_of(0.0, DT))
    assert (np.abs(out) <= limits).all()


def test_a_robot_in_its_slot_whose_neighbours_are_in_theirs_drives_as_its_slot() -> None:
    _, targets, stage = problem(0)
    far = targets.bodies + np.array([1.0, 0.0, 0.0])
    still = targets._replace(error=np.zeros_like(targets.error), drift=np.zeros(2), bodies=far)
    start = np.concatenate([targets.slots[0], targets.inputs[0]])
    _, out = solved(start, targets.inputs, still, stage, lag_of(0.1, DT))
    np.testing.assert_allclose(out, targets.inputs, atol=1e-12)


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_a_step_that_fails_says_so(bad: float) -> None:
    start, targets, stage = problem(0)
    start[0] = bad
    change, _ = solved(start, targets.inputs, targets, stage, lag_of(0.0, DT))
    assert np.isnan(change)
