"""The last filter on a command, whatever controller it is from: keep off the bodies in sight (docs/theory.md, 17)."""

import math
from collections.abc import Mapping
from typing import Final

import numpy as np

from agents.kernels.avoidance import Law, keep_off, roll, see, start
from agents.motor_model import UNLIMITED, MotorModel
from formation.arrays import FloatArray
from formation.faults import PERFECT, Fault
from formation.link_ids import LinkId
from formation.scenario.scenario import Scenario
from network.link import Link
from network.messages import Tick

YIELDS, INSISTS = 0.010, 0.006
"""Distance of two bodies that the robot with the higher number keeps, and the one with the lower [m]."""
RESPONSE: Final = 0.1
"""Time in which closing speeds fade, beyond the delay [s]."""
CHANGES: Final = 0.5
"""How fast others are assumed to change their velocity [m/s2]."""
LEAST: Final = 0.0003
"""Standard deviation of a sighting, at least [m]."""
STEER: Final = 1.5
"""Turn rate of a robot that turns aside, at most [rad/s]."""
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
        self._row, self._motors, self._dt = robot - 1, motors, scenario.control_interval
        body, limits = scenario.nominal, (scenario.robots.limits.v, scenario.robots.limits.omega)
        radii = np.array(scenario.bodies.radii(scenario.size))
        self._sigma = sigma = max(scenario.nominal.relative or 0.0, LEAST)
        self._gains = gains(CHANGES * self._dt**2 / sigma)
        others = np.arange(scenario.size)
        self._law = Law(
            radii + radii[self._row],
            np.where(others < self._row, YIELDS, INSISTS) + (scenario.nominal.relative or 0.0),
            np.array(limits),
            np.minimum([body.acceleration * self._dt, body.turn_acceleration * self._dt], UNLIMITED),
            min(STEER, float(limits[1])),
            min(ROUND * float(limits[0]), ROUND_STEP / (RESPONSE + motors.delay * self._dt)),
            round(KEPT / self._dt),
        )
        self._tracks = start(scenario.size)
        self._link: Link[FloatArray] = Link(scenario.seed, LinkId.poses_to(robot))
        self.who = 0
        """Number of the robot that the last command keeps off; 0 if it was not changed."""
        self._since = np.zeros(3)
        self._changed = False

    def set_faults(self, faults: Mapping[LinkId, Fault]) -> None:
        """Set the faults of the link from the world from now on."""
        self._link.fault = faults.get(self._link.id, PERFECT)

    def look(self, tick: Tick) -> None:
        """Take what is in sight at a tick, and the odometry since the last."""
        if not len(tick.seen):
            return
        k, (v, omega) = tick.seq, tick.odometry[self._row]
        roll(self._tracks, k, float(v), float(omega), self._dt)
        places = np.ascontiguousarray(tick.seen[tick.seen[:, 0] == self._row, 1:])
        if self._link.transparent:
            see(self._tracks, self._law, k, places, *self._gains, self._sigma, self._dt)
            return
        self._link.push(k, tick.stamp, places)
        for arrival in self._link.pop(tick.stamp):
            if arrival.damage is None:
                see(self._tracks, self._law, arrival.seq, arrival.message, *self._gains, self._sigma, self._dt)

    def filter(self, k: int, wheels: FloatArray, v: float, omega: float) -> tuple[float, float]:
        """The command (v, omega) of tick k [m/s, rad/s], or one that keeps off; wheels (2,) are their speeds now."""
        motors = self._motors
        command = np.array([v, omega, v])
        self.who = 1 + keep_off(
            self._tracks,
            self._law,
            self._row,
            k,
            motors.commands,
            motors.delay,
            motors.lag,
            RESPONSE + motors.delay * self._dt,
            wheels,
            self._dt,
            command,
        )
        self._since += (command[2], command[1], 1.0)
        self._changed |= self.who > 0
        return (float(command[0]), float(command[1])) if self.who else (v, omega)

    def take(self) -> FloatArray | None:
        """Mean speeds (2,) that the commands since the last call lead to, if one was changed [m/s, rad/s]."""
        mean = self._since[:2] / self._since[2] if self._changed else None
        self._since[:] = 0.0
        self._changed = False
        return mean


def gains(index: float) -> tuple[float, float]:
    """Gains of the steady alpha-beta filter with this tracking index (Kalata 1984)."""
    r = (4.0 + index - math.sqrt(8.0 * index + index * index)) / 4.0
    alpha = 1.0 - r * r
    return alpha, 2.0 * (2.0 - alpha) - 4.0 * math.sqrt(1.0 - alpha)
