"""How commands become motion, as far as the agent knows: nominal, given or learnt (docs/theory.md, section 13)."""

import math

import numpy as np

from agents.kernels.learning import learn, tau_of
from agents.kernels.learning import start as start_learning
from agents.kernels.window_state import LENGTH
from formation.arrays import FloatArray
from formation.scenario.scenario import Scenario

UNLIMITED = 1e9


class MotorModel:
    """The commands given so far, and what is believed of how the wheels follow them."""

    def __init__(self, scenario: Scenario, limits: FloatArray) -> None:
        """What is known at the start.

        Args:
            scenario: of the run.
            limits: (2,) of |v| and |omega| [m/s, rad/s].
        """
        wish, body, dt = scenario.estimator, scenario.nominal, scenario.control_interval
        self._dt = dt
        self.limits = limits
        self.change = np.minimum([body.acceleration * dt, body.turn_acceleration * dt], UNLIMITED)
        """(2,) largest change of a wheel speed in a tick [m/s, rad/s]."""
        self.delay = body.delay if isinstance(wish.delay, str) else round(wish.delay / dt)
        """Ticks from a command to its effect."""
        self.lag = body.lag if isinstance(wish.lag, str) else wish.lag
        """Time constant of the wheels [s]."""
        self._learns = (wish.delay == "learn", wish.lag == "learn")
        self._learner = start_learning(self.delay, self.rate)
        self.commands = np.zeros((LENGTH, 2))
        """By the tick they were given, row k % LENGTH [m/s, rad/s]."""

    @property
    def rate(self) -> float:
        """Share of the gap between command and wheel speed that a tick closes."""
        return 1.0 - math.exp(-self._dt / self.lag) if self.lag > 0.0 else 1.0

    def command(self, k: int, v: float, omega: float) -> None:
        """A command was given at tick k."""
        row = k % LENGTH
        self.commands[row, 0], self.commands[row, 1] = v, omega

    def observe(self, k: int, before: FloatArray, after: FloatArray) -> None:
        """Wheel speeds (2,) over tick k - 1 and over tick k, which has just ended; learns from them."""
        if not any(self._learns):
            return
        learn(self._learner, k, before, after, self.commands, self.limits, self.change, self._dt)
        if self._learns[0]:
            self.delay = int(self._learner.model[0])
        if self._learns[1]:
            self.lag = tau_of(float(self._learner.model[1]), self._dt)
