"""Bodies in sight: those that a plan keeps a distance from, and the last filter on a command (docs/theory.md, 19)."""

import math
from collections.abc import Mapping
from typing import Final

import numpy as np

from agents.kernels.nearby.avoidance import keep_off
from agents.kernels.nearby.separation import astray
from agents.kernels.nearby.sight import BODY, COLUMNS, FAR, MEMORY, PAST, foresee, roll, see
from agents.motor_model import UNLIMITED, MotorModel
from formation.arrays import FloatArray
from formation.clear.stopping import INSISTS, ORDERLY, RESPONSE, YIELDS
from formation.faults import PERFECT, Fault
from formation.link_ids import LinkId
from formation.scenario.scenario import Scenario
from network.link import Link
from network.messages import Tick

ROOMY: Final = 0.9
"""A plan keeps at most this share of the distance that neighbours' bodies have in the formation."""
CROWD: Final = 8
"""Of the bodies near by a plan counts so many."""
CHANGES: Final = 0.5
"""How fast others are assumed to change their velocity [m/s2]."""
LEAST: Final = 0.0003
"""Standard deviation of a sighting, at least [m]."""
STEER: Final = 1.5
"""Turn rate on the way round a body, at most [rad/s]."""
ROUND: Final = 0.25
"""Speed on the way round a body, as a share of the limit."""
ROUND_STEP: Final = 0.025
"""Way that it makes there before a command takes effect, at most [m]."""
KEPT: Final = 0.5
"""A body that has not been seen for so long is forgotten [s]."""


class Avoidance:
    """What one robot knows of the bodies around it, and what it makes of its own commands."""

    def __init__(self, scenario: Scenario, robot: int, motors: MotorModel) -> None:
        """Nobody in sight.

        Args:
            scenario: of the run.
            robot: its number, from 1.
            motors: how its commands become motion.
        """
        self._row, self._motors = robot - 1, motors
        n, dt = scenario.size, scenario.control_interval
        limits, body = scenario.robots.limits, scenario.nominal
        sigma = body.relative or 0.0
        radii = np.array(scenario.bodies.radii(n))
        reach = radii + radii[self._row]
        room = np.maximum(scenario.spacing - reach, 0.0)
        margins = np.minimum(np.where(np.arange(n) < self._row, YIELDS, INSISTS), ORDERLY * room)
        self._reach = np.stack([reach, margins, ROOMY * room], axis=1)
        self._law = np.array(
            [
                limits.v,
                limits.omega,
                min(body.acceleration * dt, UNLIMITED),
                min(body.turn_acceleration * dt, UNLIMITED),
                min(STEER, limits.omega),
                min(ROUND * limits.v, ROUND_STEP / (RESPONSE + motors.delay * dt)),
                round(KEPT / dt),
                *gains(CHANGES * dt**2 / max(sigma, LEAST)),
                max(sigma, LEAST),
                dt,
            ]
        )
        self.works = scenario.robots.avoid
        """Whether it does anything."""
        self._sight = (np.zeros((PAST, 3)), np.zeros((n if self.works else 0, COLUMNS)), np.zeros(MEMORY))
        """Own poses, bodies and memory (agents/kernels/nearby/sight.py)."""
        self._near, self._slip = np.zeros((CROWD, BODY)), 0.0
        self._spacing = scenario.spacing
        self._mine, self._n = np.array([n * self._row, n * robot]), n
        self._link: Link[FloatArray] = Link(scenario.seed, LinkId.poses_to(robot))
        self._command, self._since = np.zeros(3), np.zeros(3)
        self._changed = False
        self.who = 0
        """Number of the robot that the last command keeps off; 0 if it was not changed."""

    def set_faults(self, faults: Mapping[LinkId, Fault]) -> None:
        """Set the faults of the link from the world from now on."""
        self._link.fault = faults.get(self._link.id, PERFECT)

    def look(self, tick: Tick) -> None:
        """Take what is in sight at a tick, and the odometry since the last."""
        if not self.works:
            return
        k, (v, omega) = tick.seq, tick.odometry[self._row].tolist()
        roll(*self._sight, self._law, k, v, omega)
        places = self._places(tick.seen)
        if self._link.transparent:
            see(*self._sight, self._law, k, places)
            return
        self._link.push(k, tick.stamp, places)
        for arrival in self._link.pop(tick.stamp):
            if arrival.damage is None:
                see(*self._sight, self._law, arrival.seq, arrival.message)

    def _places(self, seen: FloatArray) -> FloatArray:
        """(n, 2) of the bodies in the own frame, zeros of those that are not in sight [m]."""
        places = np.zeros((self._n, 2))
        own = seen[slice(*seen[:, 0].searchsorted(self._mine))]
        places[own[:, 0].astype(int) - self._mine[0]] = own[:, 1:]
        return places

    def filter(self, k: int, wheels: FloatArray, v: float, omega: float) -> tuple[float, float]:
        """The command (v, omega) of tick k [m/s, rad/s], or one that keeps off; wheels (2,) are their speeds now."""
        if not self.works:
            return v, omega
        motors, command = self._motors, self._command
        command[0] = command[2] = v
        command[1] = omega
        self.who = 1 + keep_off(
            *self._sight,
            self._reach,
            self._law,
            self._row,
            k,
            motors.commands,
            motors.delay,
            motors.lag,
            wheels,
            self._slip,
            command,
        )
        self._since[0] += command[2]
        self._since[1] += command[1]
        self._since[2] += 1.0
        if not self.who:
            return v, omega
        self._changed = True
        return float(command[0]), float(command[1])

    def near(self, k: int, wheels: FloatArray, pose: FloatArray, slip: FloatArray, slot: FloatArray) -> FloatArray:
        """The bodies near by where a plan of tick k begins.

        Args:
            k: now.
            wheels: (2,) their speeds now [m/s, rad/s].
            pose: (3,) of the robot where the plan begins [m, m, rad].
            slip: (2,) its body velocity beyond the wheels', until the next call [m/s, rad/s].
            slot: (3,) where the robot belongs there [m, m, rad].

        Returns:
            (B, BODY) see interface.Observation; valid until the next call.
        """
        self._slip = float(slip[0])
        own, bodies, memory = self._sight
        memory[FAR] = astray(slot, pose, self._spacing)
        motors, now = self._motors, (self._law, self._reach, k)
        wheeled = motors.commands, motors.delay, motors.lag, wheels, self._slip
        return self._near[: foresee(own, bodies, *now, *wheeled, pose, self._near)]

    def take(self) -> FloatArray | None:
        """Mean speeds (2,) that the commands since the last call lead to, if one was changed [m/s, rad/s]."""
        if not self.works:
            return None
        mean = self._since[:2] / self._since[2] if self._changed else None
        self._since[:] = 0.0
        self._changed = False
        return mean


def gains(index: float) -> tuple[float, float]:
    """Gains of the steady alpha-beta filter with this tracking index (Kalata 1984)."""
    r = (4.0 + index - math.sqrt(8.0 * index + index * index)) / 4.0
    alpha = 1.0 - r * r
    return alpha, 2.0 * (2.0 - alpha) - 4.0 * math.sqrt(1.0 - alpha)
