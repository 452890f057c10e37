"""What shows that data, statements and proofs of the paper are wrong: each number as (printed, mended).

experiments/errata/evidence.py has those of the equations.
"""

import math

import numpy as np

from agents.controllers.interface import NeighborEstimate, Observation
from agents.controllers.leader_follower import Follower
from agents.controllers.task import Task
from experiments.errata.evidence import Case, Numbers
from experiments.errata.ring_map import Ring, Wording
from formation.arrays import FloatArray
from formation.metrics import error_state, wrapped
from formation.paths.kinds import Circle, Corner, Figure8, Spiral
from formation.paths.path import heading
from formation.pattern import pattern, rotate
from formation.scenario.files import load
from formation.shapes import line, polygon
from network.messages import Plan

INNER = math.sqrt(3.0) / 6.0 * 0.1
"""Radius of the circle inside the triangle of the second and third test [m]."""


def inferred_centres(offsets: FloatArray, centre: FloatArray) -> FloatArray:
    """Where each pair (n, 2) believes the centre of a formation that stands perfectly [m]."""
    middle = (offsets + np.roll(offsets, 1, axis=0)) / 2
    return middle + rotate(pattern(offsets).angle, np.tile(centre, (len(offsets), 1)))


def centres_apart() -> Numbers:
    """Erratum 6: how far apart the three pairs believe the centre of a perfect triangle [m]."""

    def apart(centre: FloatArray) -> float:
        places = inferred_centres(polygon(3, 0.1), centre)
        return float(np.hypot(*(places - np.roll(places, -1, axis=0)).T).max())

    return apart(np.array([INNER, INNER])), apart(np.array([INNER, 0.0]))


def angle_in_formation() -> Numbers:
    """Erratum 7: |psi_e| of robot 2 in perfect formation at the heading of 0.464 rad where the first path starts."""
    theta, offsets = math.atan(0.5), line(2, 0.1)
    poses = np.column_stack([rotate(np.array(theta), offsets), np.full(2, theta)])

    def seen(psi_r: float) -> float:
        return abs(float(error_state(poses[1], poses[0], np.array([0, 0, theta]), 0.1, psi_r, np.zeros(2))[4]))

    return seen(-theta), seen(theta + math.pi)


def first_heading() -> Numbers:
    """Erratum 8: the heading at t = 0 [rad] as printed, and of the path."""
    return math.pi / 6.0, float(heading(Figure8(kind="figure8"), np.array(1e-6), 1e-6))


def fourth_path() -> Numbers:
    """Erratum 9: the largest distance from the origin in 126 s [m]."""
    t = np.linspace(0.0, 126.0, 1261)
    paths = Circle(kind="circle", radius=0.01, rate=0.1), Spiral(kind="spiral")
    return tuple(float(np.hypot(*path.position(t).T).max()) for path in paths)


def weights_of_the_third_test() -> Numbers:
    """Erratum 10: entries of Q as printed, and of the error state."""
    return float(len((0.1, 0.1, 0.2, 0.01))), float(len(Case(0).z))


def lyapunov_slope() -> Numbers:
    """Erratum 11: dV/dt of V = (e_x^2 + e_y^2 + e_theta^2)/2 at e = (0, 0.1, 0.01), v_l = 0.2, leader straight on."""
    v_l, e_y, e_theta, gain = 0.2, 0.1, 0.01, 0.1

    def slope(steering: float) -> float:  # e_x = 0, so v = v_l cos e_theta and e_x' e_x = 0
        return e_y * v_l * math.sin(e_theta) - e_theta * (gain * e_theta + steering)

    return slope(v_l * e_y * math.sin(e_theta) / e_y), slope(v_l * e_y * math.sin(e_theta) / e_theta)


def product_of_two() -> Numbers:
    """Erratum 12: v^T S K v for two PSD matrices, least v^T W v / v^T v, and the least eigenvalue of W = I + S K."""
    s, k, v = np.diag([9.0, 0.0]), np.array([[1.0, 2.0], [2.0, 4.0]]), np.array([1.0, -1.0])
    w = np.eye(2) + s @ k
    return float(v @ s @ k @ v), float(np.linalg.eigvalsh((w + w.T) / 2).min()), float(np.linalg.eigvals(w).real.min())


def turned_frame() -> Numbers:
    """Erratum 17: change of (l, psi) of one pair when the frame is turned by 0.5 rad [m, rad]."""
    own, other = Case(7).poses(Case(7).z)

    def seen(angle: float) -> FloatArray:
        dx, dy = rotate(np.array(-angle), (own - other)[:2])
        return np.array([math.hypot(dx, dy), math.atan2(dx, -dy)])

    change = seen(0.5) - seen(0.0)
    return float(abs(change[0])), float(abs(math.atan2(math.sin(change[1]), math.cos(change[1]))))


def headings_on_the_circle() -> Numbers:
    """Erratum 18: what the formation of the third test demands at z = 0 for all three pairs.

    The largest difference of a slot's own direction of motion from theta_r [rad], and the speed at which the pattern
    would come apart if all headings were theta_r [m/s]; with a triangle that does not turn both are 0.
    """
    rate, radius = 0.05, 0.8
    offsets = polygon(3, 0.1)
    velocity = rate * np.column_stack([radius - offsets[:, 1], offsets[:, 0]])  # in the path's frame: forward, left
    turn = np.abs(np.arctan2(velocity[:, 1], velocity[:, 0])).max()
    apart = np.abs(velocity[:, 1] - np.roll(velocity[:, 1], 1)).max()
    return float(turn), float(apart)


def singular_r() -> Numbers:
    """Erratum 20: an R that (4) allows, and the rank that R^-1 of (8) and (10) would need."""
    r = np.diag([0.1, 0.0])
    return float(np.linalg.eigvalsh(r).min()), float(np.linalg.matrix_rank(r))


def singular_k() -> Numbers:
    """Erratum 21: the rank of a K that theorem 2 allows, and the asymmetry of K W^-1 with it (it stays symmetric)."""
    k, b = np.diag([0.1, 0.1, 0.1, 0.2, 0.0]), np.random.default_rng(0).normal(size=(5, 4))
    product = k @ np.linalg.inv(np.eye(5) + b @ b.T @ k)
    return float(np.linalg.matrix_rank(k)), float(np.abs(product - product.T).max())


def square_of_a_real() -> Numbers:
    """Erratum 22: v^T M^T M v is never negative, yet this symmetric matrix has v^T S v below zero."""
    return (float(np.linalg.eigvalsh(np.array([[0.0, 1.0], [1.0, 0.0]])).min()),)


def corner_jump() -> Numbers:
    """Erratum 25: jump of the reference's velocity at t = 20 s of the second test [m/s]; of the first path there."""

    def jump(path: Corner | Figure8) -> float:
        h = 1e-6
        before, at, after = path.position(np.array([20.0 - h, 20.0, 20.0 + h]))
        return float(np.hypot(*((after - at) - (at - before))) / h)

    return jump(Corner(kind="corner")), jump(Figure8(kind="figure8"))


def growing_triangle() -> Numbers:
    """Erratum 26: error of dx_e/dt by eq. (3) while l_r of a triangle grows at 0.05 m/s [m/s]; while it stays.

    All stands still; p_v = (sqrt3/6 l_r, 0) moves the inferred centre, which eq. (3) leaves out.
    """
    offsets = polygon(3, 0.1)

    def rate(growth: float) -> float:
        h = 1e-6

        def x_e(t: float) -> float:
            l_r = 0.1 + growth * t
            poses = np.column_stack([offsets, np.zeros(3)])
            centre, angle = np.array([math.sqrt(3.0) / 6.0 * l_r, 0.0]), float(pattern(offsets).angle[1])
            return float(np.abs(error_state(poses[1], poses[0], np.zeros(3), l_r, angle, centre)[:2]).max())

        return abs(x_e(h) - x_e(0.0)) / h

    return rate(0.05), rate(0.0)


def mean_heading() -> Numbers:
    """Erratum 27: error of theta_c of two robots that both head 3.2 rad and 3.1 rad, by arctan2's range; unwrapped."""
    true = np.array([3.2, 3.1])
    printed = wrapped(true).mean()
    mended = true[0] + wrapped(true[1:] - true[:1])[0] / 2.0
    off = np.abs(wrapped(np.array([printed, mended]) - true.mean()))
    return float(off[0]), float(off[1])


def leaving_the_place() -> Numbers:
    """Erratum 13: speed at which a follower leaves its place, where it stands exactly, on Ref. path 2 [m/s]."""
    speeds = []
    for errata in ((), (13,)):
        scenario = load("circle", {"controller": {"name": "leader_follower", "errata": errata}})
        pair = Task(scenario, 2)
        place, omega_l = np.subtract(*pair.offsets(0)), 0.05
        v_l = omega_l * (0.8 + place[1] / 2.0)  # robot 1 drives outside
        leader, inputs = np.zeros(3), np.tile([v_l, omega_l], (pair.horizon, 1))
        plan = Plan(1, 0, 0.0, 0, leader, pair.interval, inputs)
        pose = np.array([*place, 0.0])
        v, omega = (
            Follower(scenario, 2, pair).plan(Observation(0, pose, NeighborEstimate(leader, inputs, plan))).inputs[0]
        )
        moved = np.array([v, 0.0]) - np.array([v_l - omega_l * place[1], omega_l * place[0]])
        speeds.append(float(np.hypot(*moved)))
        assert abs(float(omega) - omega_l) < 1e-12
    return tuple(speeds)


def orientation_turned_and_kept() -> Numbers:
    """Erratum 19: RMS l_e in the fourth 10 s of the third test, planned every 0.1 s [mm]."""
    found = [Ring(Wording(turning=turning, every=10)).simulate(40.0) for turning in (True, False)]
    return tuple(1e3 * float(rms[3]) for rms in found)


def inputs_applied() -> Numbers:
    """Erratum 23: inputs of a plan, and how many of them a tick-by-tick planner applies."""
    scenario = load("circle", {"controller": {"name": "paper"}})
    return float(scenario.controller.horizon), float(-(-scenario.controller.plan_every // scenario.stride))


def horizons() -> Numbers:
    """Erratum 24: N delta_t and N Delta_T [s]."""
    scenario = load("circle", {"controller": {"name": "paper"}})
    return tuple(
        scenario.controller.horizon * step
        for step in (scenario.control_interval, scenario.controller.prediction_interval)
    )
