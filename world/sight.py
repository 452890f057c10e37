"""What robots see of each other: the positions of all bodies within `robots.sight`, each in the observer's frame."""

import numpy as np

from formation.arrays import FloatArray, frozen
from formation.scenario.scenario import Scenario
from network.values import NO_SIGHTINGS
from world.bodies.draws import SIGHT, Draws


class Sight:
    """On-board sensors of all robots, with the noise of relative sensing. Bodies without an agent are seen too."""

    def __init__(self, scenario: Scenario) -> None:
        n = scenario.size
        self._range, self._works = scenario.robots.sight, scenario.robots.avoid
        self._sigma = scenario.bodies.relative.sigma or 0.0
        self._draws = Draws(scenario.seed, SIGHT, n, 2 * n)
        self._one, self._other = np.nonzero(~np.eye(n, dtype=bool))

    def see(self, tick: int, poses: FloatArray) -> FloatArray:
        """(m, 4) of this tick, robots being at poses (n, 3): row of the observer, row of the other, x, y [m]."""
        if not self._works:
            return NO_SIGHTINGS
        gap = poses[self._other, :2] - poses[self._one, :2]
        near = np.einsum("ij,ij->i", gap, gap) <= self._range**2
        one, other, gap = self._one[near], self._other[near], gap[near]
        c, s = np.cos(poses[one, 2]), np.sin(poses[one, 2])
        seen = np.stack([one, other, c * gap[:, 0] + s * gap[:, 1], c * gap[:, 1] - s * gap[:, 0]], axis=1)
        if self._sigma > 0.0:
            noise = self._draws.at(tick).reshape(len(poses), len(poses), 2)
            seen[:, 2:] += self._sigma * noise[one, other]
        return frozen(seen)
