"""The paper's algorithm, and every erratum of its algorithm and data shown (docs/theory.md, section 4)."""

# mypy: disable-error-code="arg-type, call-arg, no-any-return, return-value"
# (unpacked poses, numpy scalars and shapes; what strict typing of numpy makes of test arithmetic)

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from agents.controllers.interface import NeighborEstimate, Observation
from agents.controllers.leader_follower import Follower
from agents.controllers.paper import Q_MORE, Q_TWO, Paper
from agents.controllers.task import Task
from agents.kernels import paper_errors, paper_game
from experiments.errata import evidence
from formation.arrays import FloatArray
from formation.metrics import error_state
from formation.paths.kinds import Circle, Figure8, Spiral
from formation.pattern import pattern, rotate
from formation.scenario.files import load
from formation.shapes import line, polygon
from formation.unicycle import step
from network.messages import Plan
from runtime.inprocess import simulate

DT = 0.1
ALL = (1, 2, 3)
"""The errata of eq. (3) and of its Jacobians."""


class Case(evidence.Case):
    """A pair, judged by the exact error dynamics too."""

    def formula_rate(self, z: FloatArray, u: FloatArray, w: FloatArray) -> FloatArray:
        """dz/dt by docs/theory.md, section 2."""
        own, other = self.poses(z)
        theta_c, psi, length = (own[2] + other[2]) / 2, self.psi_r - z[4], self.distance - z[3]
        (v_i, _), (v_u, _), omega_c = u, w, (u[1] + w[1]) / 2
        v_r, omega_r = self.reference[3:]
        xi_1 = self.pv[0] * math.sin(theta_c - psi) - self.pv[1] * math.cos(theta_c - psi)
        xi_2 = self.pv[0] * math.cos(theta_c - psi) + self.pv[1] * math.sin(theta_c - psi)
        turn = (v_i * math.cos(psi - own[2]) - v_u * math.cos(psi - other[2])) / length
        ahead = (v_i * math.cos(own[2] - theta_c) + v_u * math.cos(other[2] - theta_c)) / 2
        aside = (v_i * math.sin(own[2] - theta_c) + v_u * math.sin(other[2] - theta_c)) / 2
        return np.array(
            [
                omega_c * z[1] + v_r * math.cos(z[2]) - ahead - turn * xi_1,
                -omega_c * z[0] + v_r * math.sin(z[2]) - aside - turn * xi_2,
                omega_r - omega_c,
                -v_i * math.sin(psi - own[2]) + v_u * math.sin(psi - other[2]),
                omega_r - turn,
            ]
        )

    def jacobians(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """d(z + DT dz/dt) by z, u and w: central differences of the exact rate."""
        h = 1e-6

        def by(which: int, size: int) -> FloatArray:
            columns = []
            for n in range(size):
                values = [self.z.copy(), self.u.copy(), self.w.copy()]
                values[which][n] += h
                plus = self.formula_rate(*values)
                values[which][n] -= 2 * h
                columns.append((plus - self.formula_rate(*values)) / (2 * h))
            return DT * np.array(columns).T

        return np.eye(5) + by(0, 5), by(1, 2), by(2, 2)

    def printed(self, *mended: int) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """(A, B_i, B_-i, dz/dt) of the appendix, with these errata mended."""
        flags = np.zeros(paper_errors.SWITCHES, dtype=bool)
        flags[list(mended)] = True
        a, bi, bu, rate = np.empty((5, 5)), np.empty((5, 2)), np.empty((5, 2)), np.empty(5)
        own, other = self.poses(self.z)
        paper_errors.linearise(own, other, self.u, self.w, self.z, self.reference, self.pv, DT, flags, a, bi, bu, rate)
        return a, bi, bu, rate


SEEDS = st.integers(0, 2**32)
CASE = Case(7)
NEAR = 1e-8
"""Central differences with a step of 1e-6 of numbers of size 1 to 100."""


@given(SEEDS)
def test_the_poses_of_a_case_have_its_error_state(seed: Any) -> None:
    case = Case(seed)
    own, other = case.poses(case.z)
    z = error_state(own, other, case.reference[:3], case.distance, case.psi_r, case.pv)
    np.testing.assert_allclose(z, case.z, atol=1e-12)


@given(SEEDS)
def test_the_error_dynamics_of_the_theory_are_those_of_the_exact_motion(seed: Any) -> None:
    case = Case(seed)
    np.testing.assert_allclose(
        case.formula_rate(case.z, case.u, case.w), case.exact_rate(case.z, case.u, case.w), atol=1e-6
    )


@given(SEEDS)
def test_with_errata_1_2_and_3_mended_rate_and_jacobians_are_exact(seed: Any) -> None:
    case = Case(seed)
    a, bi, bu, rate = case.printed(*ALL)
    np.testing.assert_allclose(rate, case.formula_rate(case.z, case.u, case.w), atol=1e-12)
    for got, exact in zip((a, bi, bu), case.jacobians(), strict=True):
        np.testing.assert_allclose(got, exact, atol=NEAR)


def differing(got: FloatArray, exact: FloatArray) -> set[tuple[int, ...]]:
    """Where two arrays differ by more than finite differences do."""
    return {tuple(int(i) for i in place) for place in np.argwhere(np.abs(got - exact) > 1e-4)}


def test_erratum_1_omega_times_xi_does_not_belong_into_the_rows_x_and_y() -> None:
    a, bi, bu, rate = CASE.printed(2, 3)
    exact = CASE.jacobians()
    assert differing(rate, CASE.formula_rate(CASE.z, CASE.u, CASE.w)) == {(0,), (1,)}
    # xi depends on theta_e and psi_e, and omega_c on both omegas.
    assert differing(a, exact[0]) == {(0, 2), (0, 4), (1, 2), (1, 4)}
    assert differing(bi, exact[1]) == differing(bu, exact[2]) == {(0, 1), (1, 1)}


def test_erratum_1_does_not_show_with_a_virtual_centre_of_zero() -> None:
    case = Case(7)
    case.pv = np.zeros(2)
    for got, mended in zip(case.printed(2, 3), case.printed(1, 2, 3), strict=True):
        np.testing.assert_array_equal(got, mended)


def test_erratum_2_the_centres_velocity_depends_on_both_headings() -> None:
    a, bi, bu, rate = CASE.printed(1, 3)
    exact = CASE.jacobians()
    assert differing(rate, CASE.formula_rate(CASE.z, CASE.u, CASE.w)) == {(0,), (1,)}
    assert differing(bi, exact[1]) == differing(bu, exact[2]) == {(0, 0), (1, 0)}
    np.testing.assert_allclose(a, exact[0], atol=NEAR)  # with theta_i - theta_c held, A is not concerned


def test_erratum_2_does_not_show_when_both_robots_point_the_same_way() -> None:
    case = Case(7)
    case.half = 0.0
    for got, mended in zip(case.printed(1, 3), case.printed(1, 2, 3), strict=True):
        np.testing.assert_allclose(got, mended, atol=1e-15)


def test_erratum_3_the_column_of_theta_e_has_a_factor_2_too_much() -> None:
    a, bi, bu, rate = CASE.printed(1, 2)
    exact = CASE.jacobians()
    wrong = differing(a, exact[0])
    assert wrong == {(0, 2), (1, 2), (3, 2), (4, 2), (4, 3)}
    np.testing.assert_allclose(bi, exact[1], atol=NEAR)
    np.testing.assert_allclose(bu, exact[2], atol=NEAR)
    np.testing.assert_allclose(rate, CASE.formula_rate(CASE.z, CASE.u, CASE.w), atol=1e-12)
    assert a[3, 2] == pytest.approx(2 * exact[0][3, 2], abs=NEAR)
    assert a[4, 2] == pytest.approx(2 * exact[0][4, 2], abs=NEAR)


def test_erratum_3_the_second_term_of_a54_is_a_cosine() -> None:
    own, other = CASE.poses(CASE.z)
    psi, length = CASE.psi_r - CASE.z[4], CASE.distance - CASE.z[3]
    first = CASE.u[0] * math.cos(psi - own[2])
    printed = -(first - CASE.w[0] * math.sin(psi - other[2])) / length**2
    mended = -(first - CASE.w[0] * math.cos(psi - other[2])) / length**2
    assert CASE.printed(1, 2)[0][4, 3] == pytest.approx(DT * printed)
    assert CASE.printed(1, 2, 3)[0][4, 3] == pytest.approx(DT * mended)
    assert CASE.jacobians()[0][4, 3] == pytest.approx(DT * mended, abs=NEAR)
    assert abs(printed - mended) > 0.1


# ---------------------------------------------------------------- the solve


class Bench:
    """Two robots in line on a straight line, one of them planning."""

    def __init__(self, *errata: int, kind: str = "line", **more: object) -> None:
        path = "path={kind='line', speed=0.1}" if kind == "line" else f"path.kind={kind}"
        settings_ = [path, "controller.name=paper", f"controller.errata={list(errata)}"]
        self.scenario = load("circle", settings_ + [f"{key}={value}" for key, value in more.items()])
        self.task = Task(self.scenario, 1)
        self.paper = Paper(self.scenario, 1, self.task)
        self.block, _ = self.task.block(0)

    def plan(self, k: int, pose: FloatArray, other: FloatArray, w: FloatArray) -> FloatArray:
        message = Plan(2, k, k * 0.01, 0, other, DT, w)
        return self.paper.plan(Observation(k, pose, NeighborEstimate(other, w, message))).inputs


@pytest.mark.parametrize("mended", [True, False])
def test_erratum_4_on_the_reference_the_inputs_are_the_references_own(mended: Any) -> None:
    bench = Bench(*((1, 2, 3, 4) if mended else (1, 2, 3)))
    slots = bench.block.slots[0]
    w = np.tile([0.1, 0.0], (20, 1))
    for _ in range(10):  # from the zero plan of step 2
        inputs = bench.plan(0, slots[0], slots[1], w)
    if mended:
        np.testing.assert_allclose(inputs, w, atol=1e-6)
    else:  # it penalises absolute inputs and has no drift: with no error it sees no reason to move
        assert np.abs(inputs[:, 0]).max() < 0.09


def test_erratum_4_as_printed_a_formation_lags_behind_and_mended_it_does_not() -> None:
    def lag(*errata: int) -> float:
        settings_ = ["controller.name=paper", "duration=10", f"controller.errata={list(errata)}"]
        return float(simulate(load("circle", settings_), warmup=8.0)["tracking_error_m"]["rms"])

    # A steady lag of the order of the spacing, 0.1 m.
    assert 0.05 < lag() < 0.2
    assert lag(1, 2, 3, 4) < 0.005


def dense_joint(
    a: FloatArray, bi: FloatArray, bu: FloatArray, c: FloatArray, z0: FloatArray, q: FloatArray, r: FloatArray
) -> FloatArray:
    """Inputs (N, 4) of both players that minimise eq. (4) along z+ = A z + B u + c, as one stacked problem."""
    steps = len(a)
    g, free = np.zeros((5 * steps, 4 * steps)), np.zeros((5 * steps,))
    row, offset = np.zeros((5, 4 * steps)), z0
    for j in range(steps):
        row = a[j] @ row
        row[:, 4 * j : 4 * j + 4] += np.hstack([bi[j], bu[j]])
        offset = a[j] @ offset + c[j]
        g[5 * j : 5 * j + 5], free[5 * j : 5 * j + 5] = row, offset
    big = np.diag(np.tile(q, steps))
    hessian = g.T @ big @ g + np.diag(np.tile([*r, *r], steps))
    return np.linalg.solve(hessian, -g.T @ big @ free).reshape(steps, 4)


@pytest.mark.parametrize("seed", range(3))
def test_erratum_5_playing_the_equilibrium_is_the_pairs_joint_optimum(seed: Any) -> None:
    case, g = Case(seed), np.random.default_rng(seed)
    steps, q, r = 8, np.array(Q_TWO), np.array([0.1, 0.1])
    own, other = case.poses(case.z)
    u, w = g.uniform(0, 0.2, (steps, 2)), g.uniform(0, 0.2, (steps, 2))
    ref = np.array(
        [[*step(*case.reference[:3], *case.reference[3:], j * DT), *case.reference[3:]] for j in range(steps + 1)]
    )
    psi_r = ref[:, 2] + 0.3
    data = (case.distance, case.pv, DT, q, r, np.array([1e6, 1e6]))
    out, answer = np.empty((steps, 2)), np.empty((steps, 2))
    flags = np.zeros(paper_errors.SWITCHES, dtype=bool)
    flags[[1, 2, 3, 5]] = True
    paper_game.plan(own, u, other, w, ref, psi_r, *data, flags, out)

    # The same linearisation, along the Euler roll-out of eq. (1).
    a, bi, bu, rate = np.empty((steps, 5, 5)), np.empty((steps, 5, 2)), np.empty((steps, 5, 2)), np.empty(5)
    z, first, p, o = np.empty(5), np.empty(5), own.copy(), other.copy()
    for j in range(steps):
        paper_errors.error_state(p, o, ref[j], case.distance, psi_r[j], case.pv, z)
        if j == 0:
            first[:] = z
        paper_errors.linearise(p, o, u[j], w[j], z, ref[j], case.pv, DT, flags, a[j], bi[j], bu[j], rate)
        for body, inputs in ((p, u[j]), (o, w[j])):
            body[:] += DT * np.array([inputs[0] * math.cos(body[2]), inputs[0] * math.sin(body[2]), inputs[1]])
    joint = dense_joint(a, bi, bu, np.zeros((steps, 5)), first, q, r)
    np.testing.assert_allclose(out, joint[:, :2], atol=1e-9)

    flags[5] = False  # eq. (11) as printed answers the received plan: something else, as that is not the equilibrium
    paper_game.plan(own, u, other, w, ref, psi_r, *data, flags, answer)
    assert np.abs(answer - out).max() > 1e-3


@given(SEEDS)
@settings(max_examples=30)
def test_the_papers_inputs_keep_the_limits(seed: Any) -> None:
    g = np.random.default_rng(seed)
    bench = Bench()
    slots = bench.block.slots[0]
    inputs = bench.plan(0, slots[0] + g.normal(0, 1, 3), slots[1] + g.normal(0, 1, 3), g.uniform(-1, 1, (20, 2)))
    assert np.abs(inputs[:, 0]).max() <= 0.5
    assert np.abs(inputs[:, 1]).max() <= 2.0


def test_the_weights_are_those_of_the_tests_and_erratum_10_gives_the_third_the_second_tests_q() -> None:
    assert Q_TWO == (0.1, 0.1, 0.1, 0.5, 0.001)
    assert Q_MORE == (0.1, 0.1, 0.1, 0.2, 0.01)  # printed with four entries in the third test
    scenario = load("triangle-circle", ["controller.name=paper"])
    assert tuple(Paper(scenario, 1, Task(scenario, 1))._q) == Q_MORE


# ---------------------------------------------------------------- errata of the data


def inferred_centres(offsets: FloatArray, centre: FloatArray) -> FloatArray:
    """Where each pair believes the centre of a formation that stands perfectly."""
    return (offsets + np.roll(offsets, 1, axis=0)) / 2 + rotate(
        pattern(offsets).angle, np.tile(centre, (len(offsets), 1))
    )


def test_erratum_6_only_without_its_second_entry_is_p_v_the_centroid_of_all_three_pairs() -> None:
    offsets, l_r = polygon(3, 0.1), 0.1
    printed = inferred_centres(offsets, np.array([math.sqrt(3) / 6 * l_r, math.sqrt(3) / 6 * l_r]))
    mended = inferred_centres(offsets, np.array([math.sqrt(3) / 6 * l_r, 0.0]))
    np.testing.assert_allclose(mended, 0.0, atol=1e-15)
    gaps = np.hypot(*(printed - np.roll(printed, 1, axis=0)).T)
    assert gaps.min() > 0.04  # three centres 5 cm apart: infeasible
    np.testing.assert_allclose(pattern(offsets).centre, [[math.sqrt(3) / 6 * l_r, 0.0]] * 3, atol=1e-15)


def test_the_misprint_6_is_brought_back_on_request() -> None:
    scenario = load("triangle-circle", ["controller.name=paper", "controller.misprints=[6]"])
    controller = Paper(scenario, 2, Task(scenario, 2))
    np.testing.assert_allclose(controller._pattern(0)[2], math.sqrt(3) / 6 * 0.1)


def test_erratum_7_the_second_robots_psi_r_is_theta_r_plus_pi() -> None:
    offsets = line(2, 0.1)
    for theta in (0.0, 0.4, 2.0):
        poses = np.column_stack([rotate(np.array(theta), offsets), np.full(2, theta)])
        z = [
            error_state(poses[1], poses[0], np.array([0.0, 0.0, theta]), 0.1, psi_r, np.zeros(2))
            for psi_r in (-theta, theta + math.pi)
        ]
        np.testing.assert_allclose(z[1], 0.0, atol=1e-12)
        assert abs(z[0][4]) > 0.5  # in perfect formation the printed value sees an error of pi - 2 theta


def test_the_misprint_7_is_the_second_robots_alone() -> None:
    scenario = load("figure8", ["controller.name=paper", "controller.misprints=[7]"])
    assert [Paper(scenario, robot, Task(scenario, robot))._mirrored for robot in (1, 2)] == [False, True]


def test_erratum_8_the_first_path_starts_at_a_heading_of_atan_one_half() -> None:
    h = 1e-6
    dx, dy = Figure8(kind="figure8").position(np.array([h]))[0]
    assert math.atan2(dy, dx) == pytest.approx(math.atan(0.5), abs=1e-9)
    assert math.atan(0.5) == pytest.approx(0.464, abs=5e-4)
    assert abs(math.pi / 6 - math.atan(0.5)) > 0.05


def test_erratum_9_path_4_as_printed_is_a_circle_of_a_centimetre() -> None:
    t = np.linspace(0, 126, 500)
    printed = Circle(kind="circle", radius=0.01, rate=0.1).position(t)
    np.testing.assert_allclose(printed, 0.01 * np.stack([np.cos(t / 10), np.sin(t / 10)], axis=1), atol=1e-15)
    np.testing.assert_allclose(np.hypot(*printed.T), 0.01, atol=1e-15)
    mended = Spiral(kind="spiral").position(t)
    np.testing.assert_allclose(mended, t[:, None] * printed, atol=1e-12)
    assert np.all(np.diff(np.hypot(*mended.T)) > 0)


@given(SEEDS)
def test_erratum_11_with_e_theta_below_the_followers_errors_shrink(seed: Any) -> None:
    """V = (e_x^2 + e_y^2 + e_theta^2) / 2 has V' = -k_x e_x^2 - k_theta e_theta^2 with the mended law, exactly."""
    g = np.random.default_rng(seed)
    scenario = load("circle", ["controller.name=leader_follower", "robots.limits.v=1e6", "robots.limits.omega=1e6"])
    task = Task(scenario, 2)
    v_l, place = 0.2, -np.diff(task.offsets(0), axis=0)[0]
    leader = np.array([0.3, -0.2, g.uniform(-3, 3)])
    e_x, e_y, e_theta = g.uniform(-0.1, 0.1, 3) * np.array([1, 1, 10])
    theta = leader[2] - e_theta
    desired = leader[:2] + rotate(np.array(leader[2]), place)
    pose = np.array([*(desired - rotate(np.array(theta), np.array([e_x, e_y]))), theta])
    inputs = np.tile([v_l, 0.0], (20, 1))  # a leader that goes straight: its place moves as it does
    message = Plan(1, 0, 0.0, 0, leader, DT, inputs)
    v, omega = (
        Follower(scenario, 2, task).plan(Observation(0, pose, NeighborEstimate(leader, inputs, message))).inputs[0]
    )

    def slope(turn: float) -> float:
        d_x, d_y = v_l * math.cos(e_theta) - v + turn * e_y, v_l * math.sin(e_theta) - turn * e_x
        return e_x * d_x + e_y * d_y + e_theta * -turn

    assert slope(float(omega)) == pytest.approx(-0.1 * e_x**2 - 0.1 * e_theta**2, abs=1e-9)
    printed = 0.1 * e_theta + v_l * e_y * math.sin(e_theta) / e_y  # does not depend on e_y at all
    assert slope(printed) == pytest.approx(
        -0.1 * e_x**2 - 0.1 * e_theta**2 + v_l * math.sin(e_theta) * (e_y - e_theta), abs=1e-9
    )


def test_erratum_11_as_printed_errors_can_grow() -> None:
    v_l, e_x, e_y, e_theta = 0.2, 0.0, 0.1, 0.01
    printed = -0.1 * e_x**2 - 0.1 * e_theta**2 + v_l * math.sin(e_theta) * (e_y - e_theta)
    assert printed > 0.0


def test_erratum_12_a_product_of_psd_matrices_need_not_be_psd() -> None:
    s, k = np.diag([1.0, 0.0]), np.array([[1.0, 2.0], [2.0, 4.0]])
    assert np.linalg.eigvalsh(s).min() >= 0.0
    assert np.linalg.eigvalsh(k).min() >= -1e-15
    v = np.array([1.0, -1.0])
    assert v @ (s @ k) @ v < 0.0


@given(SEEDS, st.integers(1, 6), st.integers(0, 6), st.integers(0, 6))
def test_erratum_12_the_conclusion_stands_since_the_eigenvalues_of_w_are_at_least_one(
    seed: Any, n: Any, rank_s: Any, rank_k: Any
) -> None:
    g = np.random.default_rng(seed)
    half_s, half_k = g.normal(size=(n, rank_s)), g.normal(size=(n, rank_k))
    eigenvalues = np.linalg.eigvals(np.eye(n) + half_s @ half_s.T @ half_k @ half_k.T)
    # S K is similar to a PSD matrix; eigenvalues of a matrix that is not symmetric come with larger rounding.
    assert eigenvalues.real.min() >= 1.0 - 1e-6
    assert np.abs(eigenvalues.imag).max() < 1e-5
