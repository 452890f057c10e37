"""Gusts: pushes that come and go by chance, alone, all alike, or between (docs/theory.md, section 9)."""

import math

import numpy as np

from formation.arrays import FloatArray
from formation.scenario.scenario import Scenario
from world.bodies.draws import GUST, Draws


class Gusts:
    """Velocities that carry the robots, tick by tick: first-order autoregressive, each with variance sigma^2 per axis.

    With correlation c a robot's gust is sqrt(c) times one that all share plus sqrt(1 - c) times its own, so that c is
    the correlation of any two robots' gusts whatever their number.
    """

    def __init__(self, scenario: Scenario) -> None:
        """Gusts with the distribution that they keep from then on."""
        own = scenario.body.gusts
        self._sigma = own.sigma
        self._shares = math.sqrt(own.correlation), math.sqrt(1.0 - own.correlation)
        self._keep = math.exp(-scenario.control_interval / own.time)
        self._draws = Draws(scenario.seed, GUST, scenario.size + 1, 2)
        self._now: FloatArray | None = None
        """(n + 1, 2) of unit variance: the shared one, then each robot's own."""

    @property
    def blow(self) -> bool:
        """Whether there are any."""
        return self._sigma > 0.0

    def at(self, tick: int) -> FloatArray:
        """(n, 3) velocities at this tick, in the world's frame [m/s, m/s, rad/s]; ask for every tick in order."""
        fresh = self._draws.at(tick)
        blend = math.sqrt(1.0 - self._keep * self._keep)
        self._now = fresh if self._now is None else self._keep * self._now + blend * fresh
        shared, own = self._shares
        pushes = np.zeros((len(fresh) - 1, 3))
        pushes[:, :2] = self._sigma * (shared * self._now[0] + own * self._now[1:])
        return pushes
