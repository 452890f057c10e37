"""What shows that the equations are misprinted: each number as (printed, mended), computed from the product's code.

One `Case` is a pair of robots somewhere, with inputs, reference and virtual centre drawn from a seed; its exact motion
judges eq. (3) and the appendix. experiments/errata/errata.py puts these numbers into a table,
tests/experiments/errata holds them.
"""

import math

import numpy as np

from agents.controllers.paper import Q_TWO, R
from agents.kernels import paper_errors, paper_game
from formation.arrays import FloatArray
from formation.metrics import error_state
from formation.pattern import rotate
from formation.unicycle import step

DT = 0.1
"""Delta_T [s]."""
CASES = 20
"""Random pairs per number."""
Numbers = tuple[float, ...]


class Case:
    """A pair of robots somewhere; `half` is theta_i - theta_c, which the error state does not tell."""

    def __init__(self, seed: int) -> None:
        g = np.random.default_rng(seed)
        self.reference = np.array([*g.uniform(-1, 1, 2), g.uniform(-3, 3), g.uniform(0.05, 0.3), g.uniform(-0.5, 0.5)])
        self.distance, self.psi_r = g.uniform(0.1, 0.3), g.uniform(-3, 3)
        self.pv = g.uniform(0.03, 0.1, 2) * g.choice([-1, 1], 2)
        self.z = np.array(
            [*g.uniform(-0.05, 0.05, 2), g.uniform(-0.3, 0.3), g.uniform(-0.05, 0.05), g.uniform(-0.3, 0.3)]
        )
        self.half = g.uniform(0.2, 0.6) * g.choice([-1, 1])
        self.u = np.array([g.uniform(0.1, 0.4), g.uniform(0.2, 0.8)])
        self.w = np.array([g.uniform(0.1, 0.4), g.uniform(0.2, 0.8)])

    def poses(self, z: FloatArray, reference: FloatArray | None = None) -> tuple[FloatArray, FloatArray]:
        """Poses of the pair whose error state is z (5,), with theta_i - theta_c, and the reference (5,), as drawn."""
        ref = self.reference if reference is None else reference
        theta_c, length, psi = ref[2] - z[2], self.distance - z[3], self.psi_r - z[4]
        virtual = ref[:2] - rotate(np.array(theta_c), z[:2])
        middle = virtual - rotate(np.array(psi), self.pv)
        edge = length * np.array([-math.sin(psi), math.cos(psi)])
        return np.append(middle - edge / 2, theta_c + self.half), np.append(middle + edge / 2, theta_c - self.half)

    def exact_rate(self, z: FloatArray, u: FloatArray, w: FloatArray) -> FloatArray:
        """dz/dt (5,) by moving everything: bodies by the exact unicycle, the reference by (v_r, omega_r)."""
        own, other = self.poses(z)
        h = 1e-5

        def at(t: float) -> FloatArray:
            x, y, theta, v, omega = self.reference
            ref = np.array(step(x, y, theta, v, omega, t))
            return error_state(
                moved(own, u, t), moved(other, w, t), ref, self.distance, self.psi_r + omega * t, self.pv
            )

        return (at(h) - at(-h)) / (2 * h)

    def exact_slope(self) -> FloatArray:
        """d(dz/dt)/dz (5, 5), central differences of the exact rate."""
        h = 1e-4
        sides = [[self.exact_rate(self.z + s * h * row, self.u, self.w) for s in (1.0, -1.0)] for row in np.eye(5)]
        return np.array([(plus - minus) / (2 * h) for plus, minus in sides]).T

    def printed(self, *mended: int) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """(A, B_i, B_-i, dz/dt) of the appendix and eq. (3), with these errata mended."""
        a, bi, bu, rate = np.empty((5, 5)), np.empty((5, 2)), np.empty((5, 2)), np.empty(5)
        own, other = self.poses(self.z)
        paper_errors.linearise(
            own, other, self.u, self.w, self.z, self.reference, self.pv, DT, switches(*mended), a, bi, bu, rate
        )
        return a, bi, bu, rate


def moved(pose: FloatArray, inputs: FloatArray, t: float) -> FloatArray:
    """Pose (3,) after holding inputs (2,) for t."""
    x, y, theta = pose.tolist()
    return np.array(step(x, y, theta, float(inputs[0]), float(inputs[1]), t))


def switches(*mended: int) -> FloatArray:
    """Flags of the kernels with these switches on."""
    flags = np.zeros(paper_errors.SWITCHES, dtype=bool)
    flags[list(mended)] = True
    return flags


def rate_errors(number: int) -> Numbers:
    """Errata 1, 2: largest error of dz/dt by eq. (3) [m/s], the other one mended."""

    def worst(*mended: int) -> float:
        cases = [Case(seed) for seed in range(CASES)]
        return max(float(np.abs(c.printed(*mended)[3] - c.exact_rate(c.z, c.u, c.w)).max()) for c in cases)

    return worst(3 - number, 3), worst(1, 2, 3)


def theta_column_ratio() -> Numbers:
    """Erratum 3: a_43 over its true value, median of the cases."""

    def ratio(*mended: int) -> float:
        cases = [Case(seed) for seed in range(CASES)]
        return float(np.median([c.printed(*mended)[0][3, 2] / DT / c.exact_slope()[3, 2] for c in cases]))

    return ratio(1, 2), ratio(1, 2, 3)


class Game:
    """One planning step from a `Case`, and the same quadratic problem written out as stacked matrices."""

    def __init__(self, seed: int, *mended: int, steps: int = 8) -> None:
        self.case, g = Case(seed), np.random.default_rng(seed)
        case, self.steps, self.flags = self.case, steps, switches(*mended)
        self.own, self.other = case.poses(case.z)
        self.u, self.w = g.uniform(0, 0.2, (steps, 2)), g.uniform(0, 0.2, (steps, 2))
        end, held = case.reference[:3], case.reference[3:]
        path = [np.append(moved(end, held, j * DT), held) for j in range(steps + 1)]
        self.ref = np.array(path)
        self.q, self.r = np.array(Q_TWO), np.array(R)

    def play(self) -> FloatArray:
        """What robot i plays (N, 2)."""
        case, out = self.case, np.empty((self.steps, 2))
        psi_r = self.ref[:, 2] + 0.3
        data = (case.distance, case.pv, DT, self.q, self.r, np.array([1e6, 1e6]), self.flags)
        paper_game.plan(self.own, self.u, self.other, self.w, self.ref, psi_r, *data, out)
        return out

    def stacked(self) -> tuple[FloatArray, FloatArray]:
        """(hessian, gradient at 0) of eq. (4) along eq. (5), in the stacked inputs (N, 4) of both players."""
        case, n = self.case, self.steps
        a, bi, bu, rate, z = np.empty((5, 5)), np.empty((5, 2)), np.empty((5, 2)), np.empty(5), np.empty(5)
        p, o, row, free = self.own.copy(), self.other.copy(), np.zeros((5, 4 * n)), np.empty(5)
        paper_errors.error_state(p, o, self.ref[0], case.distance, self.ref[0, 2] + 0.3, case.pv, free)
        hessian, gradient = np.diag(np.tile(self.r, 2 * n)), np.zeros(4 * n)
        for j in range(n):
            paper_errors.error_state(p, o, self.ref[j], case.distance, self.ref[j, 2] + 0.3, case.pv, z)
            paper_errors.linearise(p, o, self.u[j], self.w[j], z, self.ref[j], case.pv, DT, self.flags, a, bi, bu, rate)
            row, free = a @ row, a @ free
            row[:, 4 * j : 4 * j + 4] += np.hstack([bi, bu])
            hessian, gradient = hessian + row.T @ (self.q[:, None] * row), gradient + row.T @ (self.q * free)
            for body, inputs in ((p, self.u[j]), (o, self.w[j])):
                body[:] += DT * np.array([inputs[0] * math.cos(body[2]), inputs[0] * math.sin(body[2]), inputs[1]])
        return hessian, gradient

    def joint(self) -> FloatArray:
        """Robot i's part (N, 2) of the pair's joint optimum, the equilibrium of the game that (8) and (9) state."""
        hessian, gradient = self.stacked()
        return np.asarray(np.linalg.solve(hessian, -gradient).reshape(-1, 4)[:, :2], dtype=float)

    def best_response(self) -> FloatArray:
        """What minimises J_i over robot i's inputs (N, 2) alone, given the received plan."""
        hessian, gradient = self.stacked()
        own = np.tile([True, True, False, False], self.steps)
        pull = gradient[own] + hessian[np.ix_(own, ~own)] @ self.w.ravel()
        return np.asarray(np.linalg.solve(hessian[np.ix_(own, own)], -pull).reshape(-1, 2), dtype=float)


def distance_to_equilibrium() -> Numbers:
    """Erratum 5: largest difference of what is played from the equilibrium [m/s, rad/s], median of the cases."""
    return _median_gap("joint", (1, 2, 3), (1, 2, 3, 5))


def distance_to_best_response() -> Numbers:
    """Erratum 14: largest difference of what is played from the best response to the received plan."""
    return _median_gap("best_response", (1, 2, 3), (1, 2, 3, paper_errors.BEST_RESPONSE))


def _median_gap(aim: str, *variants: tuple[int, ...]) -> Numbers:
    def gap(seed: int, mended: tuple[int, ...]) -> float:
        game = Game(seed, *mended)
        return float(np.abs(game.play() - getattr(game, aim)()).max())

    return tuple(float(np.median([gap(seed, mended) for seed in range(CASES)])) for mended in variants)


def rates_of_one_state() -> Numbers:
    """Erratum 15: spread of dl_e/dt [m/s] over pairs of one and the same z, u_i, u_-i, by theta_i - theta_c alone."""
    case = Case(7)
    rates = []
    for case.half in (-0.5, 0.0, 0.5):
        rates.append(case.exact_rate(case.z, case.u, case.w)[3])
    return (float(np.ptp(rates)),)


def controllable_directions() -> Numbers:
    """Erratum 16: rank of [B, AB, ...] of (5), two robots abreast on a straight line; of (5), and of the true motion.

    The true motion is that of the pair's six coordinates.
    """
    own, other = np.array([0.0, -0.05, 0.0]), np.array([0.0, 0.05, 0.0])
    u, ref, pv = np.array([0.1, 0.0]), np.array([0.0, 0.0, 0.0, 0.1, 0.0]), np.zeros(2)
    a, bi, bu, rate = np.empty((5, 5)), np.empty((5, 2)), np.empty((5, 2)), np.empty(5)
    paper_errors.linearise(own, other, u, u, np.zeros(5), ref, pv, DT, switches(1, 2, 3), a, bi, bu, rate)
    body = np.eye(3)
    body[1, 2] = DT * u[0]
    push = DT * np.array([[1.0, 0.0], [0.0, 0.0], [0.0, 1.0]])
    both = np.kron(np.eye(2), body).astype(float), np.kron(np.eye(2), push).astype(float)
    return float(_reached(a, np.hstack([bi, bu]))), float(_reached(*both))


def _reached(a: FloatArray, b: FloatArray) -> int:
    powers = [np.linalg.matrix_power(a, n) @ b for n in range(len(a))]
    return int(np.linalg.matrix_rank(np.hstack(powers), tol=1e-9))


def missing_drift() -> Numbers:
    """Erratum 4: error of eq. (5) after one Delta_T for a pair in formation that moves as its reference does [m]."""
    own, other, ref = np.array([0.0, -0.05, 0.0]), np.array([0.0, 0.05, 0.0]), np.array([0.0, 0.0, 0.0, 0.1, 0.0])
    a, bi, bu, rate = np.empty((5, 5)), np.empty((5, 2)), np.empty((5, 2)), np.empty(5)
    u = ref[3:]
    paper_errors.linearise(own, other, u, u, np.zeros(5), ref, np.zeros(2), DT, switches(1, 2, 3), a, bi, bu, rate)
    without = bi @ u + bu @ u  # eq. (5) at z = 0; the truth is z = 0 again
    drift = DT * rate - bi @ u - bu @ u
    return float(np.abs(without).max()), float(np.abs(without + drift).max())
