"""Laws of the compiled numerics: derivatives, carrying plans forward, and one Gauss-Newton step of the pair's game."""

# mypy: disable-error-code="arg-type, assignment, no-any-return, operator"
# (unpacked poses, numpy scalars and shapes; what strict typing of numpy makes of test arithmetic)

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from agents.belief import Belief
from agents.controllers.pair_game import PLACE, Game, weights
from agents.controllers.task import Task
from agents.kernels.pair_cost import cost, improve
from agents.kernels.unicycle import age, derivatives, shift
from formation.arrays import FloatArray
from formation.reference import BLOCK_TICKS
from formation.scenario.files import load
from formation.scenario.scenario import Scenario
from formation.unicycle import SMALL_TURN, step
from formation.unicycle import roll_out as roll_out_all
from network.messages import Plan

WIDE = np.array([1e6, 1e6])
N, DT = 20, 0.1
SEEDS = st.integers(0, 2**32)


def roll_out(pose: FloatArray, inputs: FloatArray) -> FloatArray:
    """Poses (N + 1, 3) of one robot."""
    return roll_out_all(pose[None], inputs[None], DT)[0]


def table(seed: int, scale: float = 1.0) -> FloatArray:
    return np.random.default_rng(seed).uniform(-1, 1, (N, 2)) * np.array([0.3, 1.5]) * scale


# ---------------------------------------------------------------- one unicycle


@given(
    st.floats(-4, 4),
    st.floats(-0.5, 0.5),
    st.floats(-2, 2) | st.floats(-3e-3, 3e-3) | st.just(0.0),
    st.sampled_from([0.01, 0.1, 0.5]),
)
def test_derivatives_equal_finite_differences(theta: Any, v: Any, omega: Any, dt: Any) -> None:
    got = derivatives(theta, v, omega, dt)
    h = 1e-6
    expected = []
    for d_theta, d_v, d_omega in ((h, 0, 0), (0, h, 0), (0, 0, h)):
        after = step(0.0, 0.0, theta + d_theta, v + d_v, omega + d_omega, dt)
        before = step(0.0, 0.0, theta - d_theta, v - d_v, omega - d_omega, dt)
        expected += [(after[0] - before[0]) / (2 * h), (after[1] - before[1]) / (2 * h)]
    # Central differences: rounding 1e-16 / h and a third derivative of less than 0.1 times h^2.
    np.testing.assert_allclose(got, expected, atol=2e-10)


def test_derivatives_are_continuous_where_the_series_begins() -> None:
    omega = 2 * SMALL_TURN / 0.1
    below, above = (derivatives(0.3, 0.5, omega * f, 0.1) for f in (1 - 1e-9, 1 + 1e-9))
    np.testing.assert_allclose(below, above, atol=1e-12)


# ---------------------------------------------------------------- ageing


def aged(pose: FloatArray, inputs: FloatArray, elapsed: float) -> FloatArray:
    out = np.empty(3)
    age(pose, inputs, elapsed, DT, out)
    return out


def shifted(inputs: FloatArray, elapsed: float, tail: FloatArray) -> FloatArray:
    out = np.empty((N, 2))
    shift(inputs, elapsed, DT, tail, out)
    return out


@given(SEEDS, st.integers(0, N))
def test_ageing_by_whole_intervals_is_the_roll_out(seed: Any, j: Any) -> None:
    inputs, pose = table(seed), np.array([1.0, -2.0, 0.5])
    np.testing.assert_allclose(aged(pose, inputs, j * DT), roll_out(pose, inputs)[j], atol=1e-12)


@given(SEEDS, st.integers(0, 10), st.floats(0.0, 0.9))
def test_ageing_by_a_sum_is_ageing_by_one_and_then_the_other_along_the_shifted_plan(
    seed: Any, intervals: Any, more: Any
) -> None:
    inputs, tail, pose = table(seed), np.zeros((N, 2)), np.array([1.0, -2.0, 0.5])
    first = intervals * DT
    whole = aged(pose, inputs, first + more)
    halves = aged(aged(pose, inputs, first), shifted(inputs, first, tail), more)
    np.testing.assert_allclose(halves, whole, atol=1e-9)


def test_ageing_ends_with_the_plan() -> None:
    inputs, pose = table(3), np.zeros(3)
    end = roll_out(pose, inputs)[-1]
    np.testing.assert_allclose(aged(pose, inputs, N * DT), end, atol=1e-12)
    np.testing.assert_allclose(aged(pose, inputs, 100.0), end, atol=1e-12)


@given(SEEDS)
def test_shifting_and_ageing_by_nothing_change_nothing(seed: Any) -> None:
    inputs, pose = table(seed), np.array([1.0, -2.0, 0.5])
    np.testing.assert_array_equal(shifted(inputs, 0.0, table(seed + 1)), inputs)
    np.testing.assert_array_equal(aged(pose, inputs, 0.0), pose)


@given(SEEDS, st.integers(0, 12), st.integers(0, 12))
def test_shifts_by_whole_intervals_add(seed: Any, a: Any, b: Any) -> None:
    inputs = table(seed)
    tail = np.tile([0.1, 0.2], (N, 1))  # the same on every grid
    np.testing.assert_allclose(
        shifted(shifted(inputs, a * DT, tail), b * DT, tail), shifted(inputs, (a + b) * DT, tail), atol=1e-12
    )


@given(SEEDS, st.floats(0.0, 1.0))
def test_a_shifted_input_is_the_mean_of_the_plan_over_its_interval(seed: Any, elapsed: Any) -> None:
    inputs, tail = table(seed), np.zeros((N, 2))
    out = shifted(inputs, elapsed, tail)
    fine = np.arange(0, N * DT - elapsed - DT, DT / 1000)
    at = np.minimum(((fine + elapsed + DT / 2000) / DT).astype(int), N - 1)
    for j in range(0, 9, 4):
        mean = inputs[at[j * 1000 : (j + 1) * 1000]].mean(axis=0)
        np.testing.assert_allclose(out[j], mean, atol=4e-3)  # the sum of 1000 pieces misses by one piece in a jump


@given(SEEDS, st.integers(N, 3 * N))
def test_past_its_end_a_plan_is_its_tail(seed: Any, intervals: Any) -> None:
    tail = table(seed)
    np.testing.assert_array_equal(shifted(table(seed + 1), intervals * DT, tail), tail)


@given(SEEDS, st.floats(0.0, 1.9))
def test_a_constant_plan_with_the_same_tail_shifts_to_itself(seed: Any, elapsed: Any) -> None:
    constant = np.tile(table(seed)[:1], (N, 1))
    np.testing.assert_allclose(shifted(constant, elapsed, constant), constant, atol=1e-15)


def test_a_belief_ages_with_both() -> None:
    belief, inputs, tail = Belief(), table(5), np.zeros((N, 2))
    slot = np.array([9.0, 9.0, 9.0])
    assert belief.aged(0.3, slot, tail).pose is slot  # before the first plan the neighbour is in its slot
    assert belief.seconds_old(0.3) == 0.3
    belief.receive(Plan(2, 100, 1.0, 0, np.array([1.0, 2.0, 0.3]), DT, inputs))
    now = belief.aged(1.25, slot, tail)
    np.testing.assert_allclose(now.pose, aged(np.array([1.0, 2.0, 0.3]), inputs, 0.25), atol=1e-12)
    np.testing.assert_allclose(now.inputs, shifted(inputs, 0.25, tail), atol=1e-12)
    assert belief.seconds_old(1.25) == pytest.approx(0.25)
    fresh = belief.as_if_fresh(slot, tail)
    np.testing.assert_array_equal(fresh.pose, [1.0, 2.0, 0.3])
    np.testing.assert_array_equal(fresh.inputs, inputs)
    assert belief.aged(1.0 + N * DT, slot, tail).pose is slot  # past its end it is in its slot again


@pytest.mark.parametrize(("lag", "pace"), [(0.0, 1.0), (0.0, 0.7), (0.013, 1.0), (0.2, 1.3)])
def test_a_neighbour_is_carried_along_the_reference_as_with_the_tail_that_this_gives(lag: float, pace: float) -> None:
    task, belief = Task(load("ring-16"), 3), Belief()
    task.lag, task.pace = lag, pace
    for at, k, plan in ((0.3, 30, None), (1.25, 125, 1.0), (1.25, 125, 1.3), (3.5, 350, 1.0)):
        if plan is not None:
            belief.plan = Plan(2, 100, plan, 0, np.array([1.0, 2.0, 0.3]), DT, table(5), drift=np.array([0.01, 0.0]))
        for column in (1, 3):
            found, expected = belief.ahead(at, k, task, column), belief.aged(at, *task.slot(k, column))
            assert (found.pose.tobytes(), found.inputs.tobytes()) == (
                expected.pose.tobytes(),
                expected.inputs.tobytes(),
            )
            assert (found.plan, found.age) == (expected.plan, expected.age)


def test_a_belief_takes_the_latest_stamp_and_counts_what_is_older() -> None:
    belief = Belief()
    for stamp, late in ((1.0, 0), (1.2, 0), (1.1, 1), (1.2, 2), (1.3, 2)):
        belief.receive(Plan(2, 0, stamp, 0, np.zeros(3), DT, np.zeros((N, 2))))
        assert belief.late == late
    assert belief.plan is not None
    assert belief.plan.stamp == 1.3


def test_a_plan_of_another_horizon_is_not_believed() -> None:
    belief, slot, tail = Belief(), np.zeros(3), np.zeros((N, 2))
    belief.receive(Plan(2, 0, 1.0, 0, np.ones(3), DT, np.ones((N + 1, 2))))
    assert belief.aged(1.0, slot, tail).pose is slot
    assert belief.as_if_fresh(slot, tail).inputs is tail


# ---------------------------------------------------------------- the pair's game


class Bench:
    """A pair on a scenario at a tick, with the game's data unpacked."""

    def __init__(self, name: str, k: int, robot: int = 1, *settings_: str) -> None:
        self.scenario: Scenario = load(name, settings_)
        self.k, self.robot = k, robot
        self.task = Task(self.scenario, robot)
        self.game = Game(self.scenario, robot, self.task)
        self.slots, self.aims = self.task.ahead(k).pair
        self.x0 = self.slots[0].ravel().copy()
        self.targets = self.aims.reshape(N, 4).copy()
        q, r = weights(self.scenario)
        self.q, self.r = np.array(q), np.array([*r, *r])

    def improve(self, x0: FloatArray, nominal: FloatArray, limits: FloatArray = WIDE) -> tuple[FloatArray, float]:
        out = np.empty((N, 4))
        change = improve(x0, nominal, *self._data(), self.q, self.r, limits, out)
        return out, change

    def cost(self, x0: FloatArray, inputs: FloatArray) -> float:
        return float(cost(x0, inputs, *self._data(), self.q, self.r))

    def _data(self) -> tuple[Any, ...]:
        return self.slots, self.aims, self.task.interval

    # ---- the same problem with dense matrices, from its description

    def weight(self, point: int) -> FloatArray:
        """W = J' diag(q) J of the residuals: centre, mean heading, radial, tangential, half-difference."""
        row = self.k - self.k % BLOCK_TICKS
        theta = self.scenario.reference().block(self.k).centre[self.k - row + point * self.task.stride, 2]
        pattern = self.scenario.pattern
        psi, distance = theta + pattern.angle[self.robot - 1], pattern.distance[self.robot - 1]
        n, t = np.array([-math.sin(psi), math.cos(psi)]), np.array([math.cos(psi), math.sin(psi)])
        j = np.zeros((6, 6))
        j[0, [0, 3]] = j[1, [1, 4]] = 0.5  # the mean of both position errors
        j[2, [2, 5]] = 0.5
        j[3, :2], j[3, 3:5] = -n, n
        j[4, :2], j[4, 3:5] = -t / distance, t / distance
        j[5, 2], j[5, 5] = 0.5, -0.5
        return j.T @ np.diag(self.q) @ j

    def error(self, x: FloatArray, point: int) -> FloatArray:
        e = self.slots[point].ravel() - x
        e[[2, 5]] = np.angle(np.exp(1j * e[[2, 5]]))
        return e

    def rolled(self, x0: FloatArray, inputs: FloatArray) -> FloatArray:
        return np.hstack([roll_out(x0[3 * a : 3 * a + 3], inputs[:, 2 * a : 2 * a + 2]) for a in range(2)])

    def dense_step(self, x0: FloatArray, nominal: FloatArray) -> FloatArray:
        """The minimiser (N, 4) of the stacked quadratic programme, linearised along the nominal roll-out."""
        x = self.rolled(x0, nominal)
        g = np.zeros((6 * (N + 1), 4 * N))  # dx = g du
        for j in range(N):
            a, b = np.eye(6), np.zeros((6, 4))
            for k in range(2):
                d = derivatives(x[j, 3 * k + 2], nominal[j, 2 * k], nominal[j, 2 * k + 1], DT)
                a[3 * k, 3 * k + 2], a[3 * k + 1, 3 * k + 2] = d[0], d[1]
                b[3 * k, 2 * k], b[3 * k + 1, 2 * k] = d[2], d[3]
                b[3 * k, 2 * k + 1], b[3 * k + 1, 2 * k + 1], b[3 * k + 2, 2 * k + 1] = d[4], d[5], DT
            g[6 * (j + 1) : 6 * (j + 2)] = a @ g[6 * j : 6 * (j + 1)]
            g[6 * (j + 1) : 6 * (j + 2), 4 * j : 4 * (j + 1)] += b
        big = np.zeros((6 * (N + 1), 6 * (N + 1)))
        for j in range(N + 1):
            big[6 * j : 6 * (j + 1), 6 * j : 6 * (j + 1)] = self.weight(j)
        e = np.concatenate([self.error(x[j], j) for j in range(N + 1)])
        r = np.diag(np.tile(self.r, N))
        hessian = g.T @ big @ g + r
        gradient = -g.T @ big @ e + r @ (nominal - self.targets).ravel()
        return nominal - np.linalg.solve(hessian, gradient).reshape(N, 4)


CASES = [("circle", 0, 1), ("triangle-circle", 321, 2), ("figure8", 1500, 2), ("hexagon-sinusoid", 77, 4)]
each_case = pytest.mark.parametrize(("name", "k", "robot"), CASES)


@each_case
def test_the_cost_is_that_of_the_residuals_in_the_theory(name: Any, k: Any, robot: Any) -> None:
    bench = Bench(name, k, robot)
    generator = np.random.default_rng(k)
    x0 = bench.x0 + generator.normal(0, 0.05, 6)
    inputs = bench.targets + generator.normal(0, 0.1, (N, 4))
    x = bench.rolled(x0, inputs)
    expected = 0.0
    for j in range(N + 1):
        e = bench.error(x[j], j)
        expected += 0.5 * e @ bench.weight(j) @ e
        if j < N:
            expected += 0.5 * np.sum(bench.r * (inputs[j] - bench.targets[j]) ** 2)
    assert bench.cost(x0, inputs) == pytest.approx(expected, rel=1e-10)
    assert expected > 1e-3


@each_case
@pytest.mark.parametrize("size", [0.001, 0.05])
def test_the_first_step_is_that_of_a_dense_linear_quadratic_solve(name: Any, k: Any, robot: Any, size: Any) -> None:
    bench = Bench(name, k, robot)
    generator = np.random.default_rng(k + 1)
    x0 = bench.x0 + generator.normal(0, size, 6)
    nominal = bench.targets + generator.normal(0, size, (N, 4))
    out, change = bench.improve(x0, nominal)
    dense = bench.dense_step(x0, nominal)
    # At the first point nothing has been rolled out yet: both must agree to rounding.
    np.testing.assert_allclose(out[0], dense[0], atol=1e-9)
    assert change == pytest.approx(np.abs(out - nominal).max())
    assert change > size / 10
    # Later inputs come from the non-linear roll-out and differ in second order.
    assert np.abs(out - dense).max() < 300 * size**2


@each_case
def test_at_a_perfect_formation_the_step_changes_nothing(name: Any, k: Any, robot: Any) -> None:
    bench = Bench(name, k, robot)
    bench.slots[:] = bench.rolled(bench.x0, bench.targets).reshape(N + 1, 2, 3)
    _, change = bench.improve(bench.x0, bench.targets)
    assert change < 1e-9
    assert bench.cost(bench.x0, bench.targets) < 1e-18


@each_case
def test_in_the_slots_of_a_reference_the_step_changes_next_to_nothing(name: Any, k: Any, robot: Any) -> None:
    bench = Bench(name, k, robot)
    _, change = bench.improve(bench.x0, bench.targets)
    # The arcs land within a micrometre of the slots; the step answers that with a few micrometres per 0.1 s.
    assert change < (3e-6 if name == "circle" else 1e-4)


def test_on_a_circle_the_perfect_formation_costs_nothing() -> None:
    bench = Bench("circle", 100)
    assert bench.cost(bench.x0, bench.targets) < 1e-11 * PLACE


@given(SEEDS, st.sampled_from(CASES))
@settings(max_examples=40)
def test_a_step_never_raises_the_cost_of_a_small_perturbation(seed: Any, case: Any) -> None:
    bench = Bench(*case)
    generator = np.random.default_rng(seed)
    x0 = bench.x0 + generator.normal(0, 0.01, 6)
    nominal = bench.targets + generator.normal(0, 0.02, (N, 4))
    out, _ = bench.improve(x0, nominal)
    before, after = bench.cost(x0, nominal), bench.cost(x0, out)
    assert after <= before
    again, change = bench.improve(x0, out)
    assert bench.cost(x0, again) <= after + 1e-12
    assert change < 0.7 * np.abs(out - nominal).max()  # Gauss-Newton converges: the second step is smaller


@given(SEEDS, st.floats(0.05, 0.6), st.floats(0.1, 2.0))
@settings(max_examples=30)
def test_limits_are_respected_by_both_players(seed: Any, v: Any, omega: Any) -> None:
    bench = Bench("triangle-circle", 50)
    x0 = bench.x0 + np.random.default_rng(seed).normal(0, 0.5, 6)
    out, _ = bench.improve(x0, bench.targets, np.array([v, omega]))
    assert np.isfinite(out).all()
    assert np.abs(out[:, [0, 2]]).max() <= v
    assert np.abs(out[:, [1, 3]]).max() <= omega


def test_tight_limits_are_reached() -> None:
    bench = Bench("triangle-circle", 50)
    x0 = bench.x0 + np.array([0.5, 0.5, 0.5, -0.5, -0.5, -0.5])
    out, _ = bench.improve(x0, bench.targets, np.array([0.1, 0.2]))
    assert np.abs(out[:, [0, 2]]).max() == 0.1
    assert np.abs(out[:, [1, 3]]).max() == 0.2


def test_a_step_from_nonsense_says_that_it_failed() -> None:
    bench = Bench("circle", 0)
    _, change = bench.improve(np.array([np.inf, 0, 0, 0, 0, 0]), bench.targets)
    assert math.isnan(change)


@each_case
def test_turning_and_shifting_the_scene_does_not_change_the_step(name: Any, k: Any, robot: Any) -> None:
    bench = Bench(name, k, robot)
    generator = np.random.default_rng(8)
    x0 = bench.x0 + generator.normal(0, 0.05, 6)
    nominal = bench.targets + generator.normal(0, 0.05, (N, 4))
    here, _ = bench.improve(x0, nominal)

    angle, shift_by = 0.7, np.array([0.4, -1.1])
    c, s = math.cos(angle), math.sin(angle)
    turn = np.array([[c, -s], [s, c]])

    def moved(poses: FloatArray) -> FloatArray:
        out = poses.reshape(-1, 3).copy()
        out[:, :2] = out[:, :2] @ turn.T + shift_by
        out[:, 2] += angle
        return out

    slots = np.ascontiguousarray(moved(bench.slots).reshape(bench.slots.shape))
    there = np.empty((N, 4))
    improve(moved(x0).ravel(), nominal, slots, bench.aims, bench.task.interval, bench.q, bench.r, WIDE, there)
    np.testing.assert_allclose(there, here, atol=1e-9)


@given(SEEDS)
@settings(max_examples=20)
def test_the_nash_gap_is_not_negative_and_vanishes_at_a_best_response(seed: Any) -> None:
    bench = Bench("triangle-circle", 40)
    generator = np.random.default_rng(seed)
    x0 = bench.x0 + generator.normal(0, 0.01, 6)
    inputs = bench.targets + generator.normal(0, 0.02, (N, 4))
    gap = bench.game.gap(40, x0, inputs)
    assert gap > 0.0
    for _ in range(25):  # the pair's joint optimum: nobody gains alone
        inputs, _ = bench.game.improve(40, x0, inputs)
    assert 0.0 <= bench.game.gap(40, x0, inputs) < 1e-4 * gap


def test_the_nash_gap_of_a_bad_own_plan_is_what_it_costs() -> None:
    bench = Bench("circle", 40)
    bad = bench.targets.copy()
    bad[:, 0] += 0.1  # alone too fast
    gap = bench.game.gap(40, bench.x0, bad)
    excess = bench.cost(bench.x0, bad) - bench.cost(bench.x0, bench.targets)
    assert gap == pytest.approx(excess, rel=1e-3)
