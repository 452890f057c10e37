"""What robots see of each other: the positions of all bodies within `robots.sight`, each in the observer's frame."""

import numpy as np

from formation.arrays import FloatArray, frozen
from formation.scenario.scenario import Scenario
from network.values import NO_PLACES
from world.bodies.draws import SIGHT, Draws


class Sight:
    """On-board sensors of all robots, with the noise of relative sensing. Bodies without an agent are seen too."""

    def __init__(self, scenario: Scenario) -> None:
        n = scenario.size
        self._range, self._works = scenario.robots.sight, scenario.robots.avoid
        self._sigma = scenario.bodies.relative.sigma or 0.0
        self._draws = Draws(scenario.seed, SIGHT, n, 2 * n)
        self._others = ~np.eye(n, dtype=bool)

    def see(self, tick: int, poses: FloatArray) -> FloatArray:
        """(n n, 2): where row i n + j is body j in the frame of robot i at this tick; zeros: not in sight [m]."""
        if not self._works:
            return NO_PLACES
        places = poses[:, 0] + 1j * poses[:, 1]
        seen = (places - places[:, None]) * np.exp(-1j * poses[:, 2])[:, None]
        near = (np.abs(seen) <= self._range) & self._others
        if self._sigma > 0.0:
            seen += self._sigma * self._draws.at(tick).view(complex)
        return frozen((seen * near).view(float).reshape(-1, 2))
