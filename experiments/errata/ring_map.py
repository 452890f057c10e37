"""The paper's third test as a map from one tick to the next, for any reading of the printed text.

Three robots on the circle of Ref. path 2 are a relative equilibrium if they are anything: in the frame that turns with
the path nothing depends on time. A reading is then one map of the robots' poses and plans, and its derivative tells
which deviations vanish by themselves and which do not.
"""

import math
from dataclasses import dataclass

import numpy as np

from agents.controllers.paper import Q_MORE, R
from agents.kernels.paper_errors import SWITCHES
from agents.kernels.paper_game import plan
from formation import unicycle
from formation.arrays import FloatArray
from formation.pattern import pattern, rotate
from formation.shapes import polygon

ROBOTS, RADIUS, RATE, SPACING = 3, 0.8, 0.05, 0.1
"""Ref. path 2 [m, rad/s] and l_r [m]."""
TICK = 0.01
"""delta_t [s]."""
STARTS = np.array([[0.8, 0.065, 1.5], [0.75, -0.05, 1.5], [0.85, -0.05, 1.5]])
"""As printed."""
MEASURED_EVERY = 10
"""Ticks between two looks at the errors: l_e changes slowly."""
SHOWN_RATES = 6
"""Growth rates that are looked at; the others belong to plans and vanish within a second."""
LOST = 10.0
"""Distance to the path [m] beyond which a simulation ends."""


@dataclass(frozen=True, slots=True)
class Wording:
    """One way to read what is printed. The defaults are what controller `paper` does with no erratum mended."""

    switches: tuple[int, ...] = ()
    """Of agents/kernels/paper_errors.py: errata mended, and other readings of the algorithm."""
    centre: str = "centroid"
    """p_v: "printed" (sqrt3/6, sqrt3/6) l_r, "centroid" (sqrt3/6, 0) l_r, "mirrored" (-sqrt3/6, 0) l_r, "none" 0."""
    q: tuple[float, ...] = Q_MORE
    r: tuple[float, ...] = R
    play: str = "message"
    """What robot i knows of its neighbour: the "message" of the tick before, its pose of "now" with the plan of the
    tick before, or the robots plan in "sequence" and the neighbour's plan of this tick is known."""
    every: int = 1
    """Ticks from plan to plan; the first input is held meanwhile."""
    aged: bool = False
    """Plans are carried forward by delta_t before they are used again."""
    interval: float = 0.1
    """Delta_T [s]."""
    horizon: int = 20
    """N."""
    turning: bool = True
    """psi_r = theta_r + const, or const."""
    reference: str = "printed"
    """theta_r by the last Delta_T and v_r by the next ("printed"), both by the last delta_t ("tick"), or "tangent"."""
    reversed_ring: bool = False
    """Robot i listens to i + 1."""
    clockwise: bool = False
    """The circle's direction."""
    exact: bool = True
    """The bodies move on arcs, or by eq. (1) with delta_t."""
    limits: tuple[float, float] = (0.5, 2.0)
    """|v| [m/s], |omega| [rad/s]; the paper prints none."""
    wrapped: bool = False
    """Headings are kept in (-pi, pi], as arctan2 gives them, and averaged so."""


class Ring:
    """The three robots under one wording."""

    def __init__(self, wording: Wording) -> None:
        self.wording = wording
        self._rate = -RATE if wording.clockwise else RATE
        offsets = polygon(ROBOTS, SPACING)
        self._step = 1 if wording.reversed_ring else -1
        turned = offsets if not wording.reversed_ring else offsets[::-1]
        pairs = pattern(turned)
        order = slice(None, None, -1) if wording.reversed_ring else slice(None)
        self._angle = pairs.angle[order]
        inner = math.sqrt(3.0) / 6.0 * SPACING
        self._centre = {
            "printed": np.array([inner, inner]),
            "centroid": np.array(pairs.centre[0]),
            "mirrored": -np.array(pairs.centre[0]),
            "none": np.zeros(2),
        }[wording.centre]
        self._offsets = offsets
        self._flags = np.zeros(SWITCHES, dtype=bool)
        self._flags[list(wording.switches)] = True
        self._q, self._r = np.array(wording.q, dtype=float), np.array(wording.r, dtype=float)
        self._limits = np.array(wording.limits, dtype=float)

    def centre(self, t: FloatArray) -> FloatArray:
        """Rows x_r, y_r, theta_r, v_r, omega_r (..., 5) at times t."""
        phase, sign = self._rate * t, math.copysign(1.0, self._rate)
        late = {"printed": self.wording.interval, "tick": TICK, "tangent": 0.0}[self.wording.reference]
        heading = phase + sign * math.pi / 2.0 - self._rate * late / 2.0
        speed = RADIUS * RATE * np.sinc(self._rate * late / 2.0 / math.pi)
        rows = [RADIUS * np.cos(phase), RADIUS * np.sin(phase), heading]
        return np.stack([*rows, np.full_like(t, speed), np.full_like(t, self._rate)], axis=-1)

    def start(self) -> FloatArray:
        """The state at the printed start: poses, poses as last received, plans (zero, step 2)."""
        poses = STARTS.copy()
        if self.wording.clockwise:  # the mirror image: p_1 in front again
            poses[:, 1:] *= -1.0
            poses[[1, 2]] = poses[[2, 1]]
        return np.concatenate([poses.ravel(), poses.ravel(), np.zeros(ROBOTS * self.wording.horizon * 2)])

    def advance(self, k: int, state: FloatArray) -> FloatArray:
        """The state one planning interval after tick k."""
        way, n = self.wording, self.wording.horizon
        poses, received_poses = state[:9].reshape(3, 3), state[9:18].reshape(3, 3)
        if way.wrapped:
            poses, received_poses = _wrapped(poses), _wrapped(received_poses)
        plans = state[18:].reshape(ROBOTS, n, 2)
        if way.aged:
            share = TICK * way.every / way.interval
            plans = (1.0 - share) * plans + share * np.concatenate([plans[:, 1:], plans[:, -1:]], axis=1)
        ref = self.centre(k * TICK + way.interval * np.arange(n + 1, dtype=float))
        made = plans.copy()
        seen = received_poses if way.play == "message" and not way.aged else poses
        for i in range(ROBOTS):
            j = (i + self._step) % ROBOTS
            received = made[j] if way.play == "sequence" else plans[j]
            psi = (ref[:, 2] if way.turning else np.full(n + 1, ref[0, 2] - self._rate * k * TICK)) + self._angle[i]
            plan(
                poses[i].copy(), plans[i], seen[j].copy(), received, ref, psi, SPACING, self._centre, way.interval,
                self._q, self._r, self._limits, self._flags, made[i],
            )  # fmt: skip
        moved = poses.copy()
        for i in range(ROBOTS):
            v, omega = made[i, 0].tolist()
            for _ in range(way.every):
                if way.exact:
                    x, y, theta = moved[i].tolist()
                    moved[i] = unicycle.step(x, y, theta, v, omega, TICK)
                else:
                    x, y, theta = moved[i]
                    moved[i] = x + TICK * v * math.cos(theta), y + TICK * v * math.sin(theta), theta + TICK * omega
        return np.concatenate([moved.ravel(), poses.ravel(), made.ravel()])

    def turned(self, state: FloatArray, angle: float) -> FloatArray:
        """The same state seen from a frame turned by -angle."""
        out = state.copy()
        for poses in (out[:9].reshape(3, 3), out[9:18].reshape(3, 3)):
            poses[:, :2] = rotate(np.array(angle), poses[:, :2])
            poses[:, 2] += angle
        return out

    def errors(self, state: FloatArray) -> FloatArray:
        """l_e (3,) of every robot to the one it listens to [m]."""
        places = state[:9].reshape(3, 3)[:, :2]
        return np.asarray(SPACING - np.hypot(*(places - np.roll(places, -self._step, axis=0)).T))

    def slope(self, k: int, state: FloatArray, h: float = 1e-6) -> FloatArray:
        """Derivative of one planning interval from tick k, in the frame that turns with the path."""
        back = -self._rate * TICK * self.wording.every
        columns = []
        for n in range(len(state)):
            ahead, behind = state.copy(), state.copy()
            ahead[n] += h
            behind[n] -= h
            columns.append(self.turned(self.advance(k, ahead), back) - self.turned(self.advance(k, behind), back))
        return np.array(columns).T / (2.0 * h)

    def rates(self, seconds: float) -> FloatArray:
        """Growth rates [1/s] of small deviations about the state after some seconds, the largest first."""
        state, every = self.start(), self.wording.every
        steps = round(seconds / TICK / every)
        for step in range(steps):
            state = self.advance(step * every, state)
        size = np.abs(np.linalg.eigvals(self.slope(steps * every, state)))
        return np.asarray(np.log(np.sort(size)[::-1][:SHOWN_RATES]) / (TICK * every))

    def simulate(self, seconds: float) -> FloatArray:
        """RMS l_e of the three robots in every 10 s from the printed start [m]; infinite once it is lost."""
        state, every = self.start(), self.wording.every
        steps = round(seconds / TICK / every)
        seen = max(1, MEASURED_EVERY // every)
        squares: list[FloatArray] = []
        for step in range(steps):
            if step % seen == 0:
                squares.append(self.errors(state) ** 2)
                if not np.isfinite(state).all() or np.abs(state[:9].reshape(3, 3)[:, :2]).max() > LOST:
                    break
            state = self.advance(step * every, state)
        rows = np.full((steps // seen + (steps % seen > 0), ROBOTS), np.inf)
        rows[: len(squares)] = squares
        per = round(10.0 / TICK / every / seen)
        return np.asarray(np.sqrt(rows[: len(rows) // per * per].reshape(-1, per * ROBOTS).mean(axis=1)), dtype=float)


def _wrapped(poses: FloatArray) -> FloatArray:
    """The same poses with headings in (-pi, pi]."""
    return np.column_stack([poses[:, :2], np.arctan2(np.sin(poses[:, 2]), np.cos(poses[:, 2]))])
