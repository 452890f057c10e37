"""Wheeled bodies: wheels that follow late and slowly, slip, get stuck and are pushed (docs/theory.md, section 11).

A command c acts `delay` after its arrival, held within the limits. Wheel speeds follow it,
w+ = w + clip((c - w)(1 - exp(-dt / lag)), +- acceleration dt), and odometry reads w. The body moves as a unicycle with
v = drive (1 + s_v)(1 + slip n_1) w_v and omega = drive ((1 + s_w)(1 + slip n_2) w_w + b_w + gyro n_3), and is
carried by a disturbance's drift and by gusts.
"""

import math
from collections import deque
from collections.abc import Collection, Sequence
from typing import NamedTuple, Protocol

import numpy as np

from formation import unicycle
from formation.arrays import FloatArray, read_only
from formation.bodies.nominal import Nominal
from formation.disturbances import Disturbance
from formation.scenario.scenario import Scenario
from world.bodies.draws import CONSTANT, MOTION, Draws, generator
from world.bodies.gusts import Gusts
from world.bodies.sensors import Measured, Sensors


class Constants(NamedTuple):
    """What one robot's body is like."""

    rate: float
    """Share of the gap between command and wheel speed that a tick closes; 1 without lag."""
    change: tuple[float, float]
    """Largest change of wheel speed in a tick [m/s, rad/s]."""
    limits: tuple[float, float]
    """[m/s, rad/s]."""
    gains: tuple[float, float]
    """1 + s_v, 1 + s_w."""
    offset: float
    """b_w [rad/s]."""
    slip: float
    gyro: float
    """[rad/s]."""
    exact: bool
    """Whether the wheels do what they are commanded at once."""


class Ground(Protocol):
    """What carries the robots, and what they bump into."""

    def roll(self, speeds: list[tuple[float, float]], carried: FloatArray | None, dt: float) -> FloatArray:
        """Poses (n, 3) after a tick of dt [s] in which the wheels make these v and omega; some are carried on top."""
        ...


class WheeledBodies:
    """Bodies of all robots, moved tick by tick. The same seed gives the same noise, whatever the commands."""

    def __init__(self, scenario: Scenario, ground: Ground | None = None) -> None:
        """Robots at their start, with their wheels at the speeds of their slots.

        Args:
            scenario: of the episode.
            ground: what wheels that turn do to bodies; unicycles that nothing holds up, if absent.
        """
        self._ground = ground
        self._dt = scenario.control_interval
        self._disturbances: Sequence[Disturbance] = scenario.disturbances
        known = scenario.nominal
        n = scenario.size
        self._bodies = [_constants(scenario, known, robot) for robot in range(1, n + 1)]
        slip_time = scenario.bodies.slip_time
        self._keep = math.exp(-self._dt / slip_time) if slip_time > 0.0 else 0.0
        self._slips = any(body.slip > 0.0 or body.gyro > 0.0 for body in self._bodies)
        self._undisturbed = [1.0] * n, [body.limits[0] for body in self._bodies], None, [0.0] * n
        self._motion = Draws(scenario.seed, MOTION, n, 3)
        self._slipping = [[0.0, 0.0, 0.0] for _ in range(n)]
        self._gusts = Gusts(scenario)
        self._sensors = Sensors(scenario, known)
        self._k = 0
        self.poses: FloatArray = scenario.start_poses()
        """(n, 3) true poses now, read-only [m, m, rad]."""
        block = scenario.start
        at_start: list[list[float]] = block.inputs[0].tolist()
        self._wheels = at_start
        last = len(block.inputs) - 1  # a driven formation's is short, and at rest before any order
        self._queue: deque[list[list[float]]] = deque(block.inputs[min(k, last)].tolist() for k in range(known.delay))

    @property
    def odometry(self) -> FloatArray:
        """(n, 2) speeds of the wheels over the last tick [m/s, rad/s]."""
        return read_only(np.array(self._wheels))

    def disturb(self, disturbances: Sequence[Disturbance]) -> None:
        """These disturbances count from the next tick on, and no others."""
        self._disturbances = self._sensors.disturbances = disturbances

    def close_over(self, away: Collection[int]) -> None:
        """From now on robots see their neighbours in the ring of those who are not away."""
        self._sensors.close_over(away)

    def measure(self) -> Measured | None:
        """What sensors deliver at this tick; call once a tick."""
        return self._sensors.measure(self._k, self.poses)

    def move(self, commands: FloatArray) -> None:
        """One tick on, under commands (n, 2) [m/s, rad/s]."""
        self._queue.append(commands.tolist())
        acting = self._queue.popleft()
        drive, cap, drift, slip = self._disturbed()
        noise = self._noise() if self._slips or any(slip) else None
        made, wheels = [], self._wheels
        for i, body in enumerate(self._bodies):
            _, _, (_, omega_most), (gain, turn_gain), offset, own_slip, gyro, exact = body
            share, v_most = drive[i], cap[i]
            v, omega = wanted = acting[i]
            if not (-v_most <= v <= v_most and -omega_most <= omega <= omega_most):
                wanted = [min(max(v, -v_most), v_most), min(max(omega, -omega_most), omega_most)]
            wheels[i] = speeds = wanted if exact else _spun(body, wheels[i], wanted)
            v, omega = speeds[0] * gain, speeds[1] * turn_gain
            if noise is not None:
                slipped, (along, turning, drifting) = own_slip + slip[i], noise[i]
                v, omega = v * (1.0 + slipped * along), omega * (1.0 + slipped * turning) + gyro * drifting
            made.append((v * share, (omega + offset) * share))
        if self._gusts.blow:
            gust = self._gusts.at(self._k)
            drift = gust if drift is None else drift + gust
        self.poses = read_only(self._ground.roll(made, drift, self._dt) if self._ground else self._rolled(made, drift))
        self._k += 1

    def _rolled(self, made: list[tuple[float, float]], drift: FloatArray | None) -> FloatArray:
        """Poses (n, 3) of unicycles a tick later."""
        flat: list[float] = []  # numpy takes it in half the time that rows need
        for (x, y, theta), (v, omega) in zip(self.poses.tolist(), made, strict=True):
            flat += unicycle.step(x, y, theta, v, omega, self._dt)
        poses = np.array(flat).reshape(-1, 3)
        return poses if drift is None else poses + self._dt * drift

    def _noise(self) -> list[list[float]]:
        """Three numbers of unit variance for each robot at this tick: white, or first-order autoregressive."""
        fresh: list[list[float]] = self._motion.at(self._k).tolist()
        if self._keep == 0.0:
            return fresh
        blend = math.sqrt(1.0 - self._keep * self._keep)
        self._slipping = [
            [self._keep * old + blend * new for old, new in zip(before, now, strict=True)]
            for before, now in zip(self._slipping, fresh, strict=True)
        ]
        return self._slipping

    def _disturbed(self) -> tuple[list[float], list[float], FloatArray | None, list[float]]:
        """Shares (n,) of the motion that take effect, limits (n,) of |v| [m/s], pushes (n, 3) or None, slip (n,)."""
        n = len(self._bodies)
        if not self._disturbances:
            return self._undisturbed
        drive, cap, slip = [1.0] * n, [body.limits[0] for body in self._bodies], [0.0] * n
        drift = np.zeros((n, 3))
        for entry in self._acting():
            row = entry.robot - 1
            drive[row] *= entry.drive
            drift[row] += entry.drift
            slip[row] += entry.slip
            if entry.speed is not None:
                cap[row] = min(cap[row], entry.speed)
        return drive, cap, drift, slip

    def _acting(self) -> list[Disturbance]:
        return [entry for entry in self._disturbances if entry.on(self._k * self._dt)]


def _spun(body: Constants, wheel: list[float], wanted: list[float]) -> list[float]:
    """Wheel speeds a tick later, on their way to those that are wanted."""
    for c in range(2):
        if body.rate < 1.0 or math.isfinite(body.change[c]):
            step = body.rate * (wanted[c] - wheel[c])
            wanted[c] = wheel[c] + min(max(step, -body.change[c]), body.change[c])
    return wanted


def _constants(scenario: Scenario, known: Nominal, robot: int) -> Constants:
    """The body of one robot, with what is drawn for it from the seed."""
    bodies, dt = scenario.body, scenario.control_interval
    own = bodies.of(robot)
    drawn = generator(scenario.seed, CONSTANT, robot - 1).uniform(-1.0, 1.0, 3)
    lag = known.lag if own.lag is None else own.lag
    limits = own.limits or scenario.robots.limits
    scales = [
        bound * share if given is None else given
        for bound, share, given in zip(
            (bodies.scale, bodies.turn_scale, bodies.turn_offset),
            drawn.tolist(),
            (own.scale, own.turn_scale, own.turn_offset),
            strict=True,
        )
    ]
    rate = 1.0 - math.exp(-dt / lag) if lag > 0.0 else 1.0
    change = (own.acceleration or known.acceleration) * dt, (own.turn_acceleration or known.turn_acceleration) * dt
    return Constants(
        rate,
        change,
        (limits.v, limits.omega),
        (1.0 + scales[0], 1.0 + scales[1]),
        scales[2],
        known.slip if own.slip is None else own.slip,
        known.gyro if own.gyro is None else own.gyro,
        rate >= 1.0 and math.isinf(min(change)),
    )
