"""How commands become motion, as far as the agent knows: nominal, given or learnt (docs/theory.md, section 13)."""

import math

import numpy as np

from agents.kernels.learning import COMMANDS, start, tau_of
from agents.kernels.window.state import LENGTH
from formation.arrays import FloatArray
from formation.scenario.scenario import Scenario

UNLIMITED = 1e9


class MotorModel:
    """The commands given so far, and what is believed of how the wheels follow them; kernels learn in its memory."""

    def __init__(self, scenario: Scenario, limits: FloatArray) -> None:
        """What is known at the start.

        Args:
            scenario: of the run.
            limits: (2,) of |v| and |omega| [m/s, rad/s].
        """
        wish, body, dt = scenario.estimator, scenario.nominal, scenario.control_interval
        self._dt = dt
        given = wish.ticks_late(dt)
        self.delay = body.delay if given is None else given
        """Ticks from a command to its effect."""
        self.lag = body.lag if isinstance(wish.lag, str) else wish.lag
        """Time constant of the wheels [s]."""
        self.rate = self._rate()
        """Share of the gap between command and wheel speed that a tick closes."""
        self._learns_delay, self._learns_lag = wish.delay == "learn", wish.lag == "learn"
        self.learns = self._learns_delay or self._learns_lag
        """Whether `learnt` is to be called when kernels have changed the memory."""
        change = np.minimum([body.acceleration * dt, body.turn_acceleration * dt], UNLIMITED)
        self.memory = start(self.delay, self.rate, limits, change)
        """The state, as compiled code takes it (agents/kernels/learning.py, Motors)."""

    def _rate(self) -> float:
        return 1.0 - math.exp(-self._dt / self.lag) if self.lag > 0.0 else 1.0

    def command(self, k: int, v: float, omega: float) -> None:
        """A command was given at tick k."""
        at = COMMANDS + 2 * (k % LENGTH)
        self.memory[at], self.memory[at + 1] = v, omega

    @property
    def commands(self) -> FloatArray:
        """(LENGTH, 2) by the tick they were given, row k % LENGTH [m/s, rad/s]."""
        return self.memory[COMMANDS : COMMANDS + 2 * LENGTH].reshape(-1, 2)

    def acting(self, k: int) -> float:
        """The commanded speed that took effect at tick k [m/s]."""
        return float(self.memory[COMMANDS + 2 * ((k - self.delay) % LENGTH)])

    def learnt(self) -> None:
        """The model in the memory has changed: believe it, as far as it is to be learnt."""
        delay, rho = self.memory[:2].tolist()
        if self._learns_delay:
            self.delay = int(delay)
        if self._learns_lag:
            self.lag = tau_of(rho, self._dt)
            self.rate = self._rate()


def within(value: float, limit: float) -> float:
    """The value, held within +- limit; quicker than by min and max."""
    return limit if value > limit else -limit if value < -limit else value
