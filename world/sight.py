"""What robots see of each other: the positions of all bodies within `robots.sight`, each in the observer's frame."""

import numpy as np
from numpy.typing import NDArray

from formation.arrays import FloatArray, IntArray, frozen
from formation.metrics import near
from formation.scenario.scenario import Scenario
from network.values import NOBODY_SEEN
from world.bodies.draws import BLOCK, SIGHT, Draws

CROWD = 64
"""Of so many robots each may see all others; of more, each sees the nearest `CROWD - 1`."""


class Sight:
    """On-board sensors of all robots, with the noise of relative sensing. Bodies without an agent are seen too."""

    def __init__(self, scenario: Scenario) -> None:
        self._n = n = scenario.size
        self._range, self._works = scenario.robots.sight, scenario.robots.avoid
        self._sigma = scenario.bodies.relative.sigma or 0.0
        width, ticks = (n, BLOCK) if n <= CROWD else (CROWD - 1, max(1, BLOCK * CROWD // n))
        self._draws = Draws(scenario.seed, SIGHT, n, 2 * width, ticks=ticks)

    def see(self, tick: int, poses: FloatArray) -> FloatArray:
        """(m, 3) who sees whom at this tick, i n + j for robot row i and body row j, and where in its frame [m]."""
        if not self._works:
            return NOBODY_SEEN
        places, turns = poses[:, 0] + 1j * poses[:, 1], np.exp(-1j * poses[:, 2])
        if self._n > CROWD:
            return self._of_crowd(tick, poses, places, turns)
        seen = (places - places[:, None]) * turns[:, None]
        within = np.abs(seen) <= self._range
        np.fill_diagonal(within, val=False)
        if self._sigma > 0.0:
            seen += self._sigma * self._draws.at(tick).view(complex)
        return _rows(np.flatnonzero(within), seen[within])

    def _of_crowd(
        self, tick: int, poses: FloatArray, places: NDArray[np.complex128], turns: NDArray[np.complex128]
    ) -> FloatArray:
        one, other = near(poses, self._range)
        who, whom = np.concatenate([one, other]), np.concatenate([other, one])
        apart = np.abs(places[whom] - places[who])
        kept = np.flatnonzero(apart <= self._range)
        kept = kept[np.lexsort((apart[kept], who[kept]))]
        kept = kept[_ranks(who[kept], self._n) < CROWD - 1]
        kept = kept[np.lexsort((whom[kept], who[kept]))]
        who, whom = who[kept], whom[kept]
        seen = (places[whom] - places[who]) * turns[who]
        if self._sigma > 0.0:
            seen += self._sigma * self._draws.at(tick).view(complex)[who, _ranks(who, self._n)]
        return _rows(who * self._n + whom, seen)


def _ranks(sorted_rows: IntArray, n: int) -> IntArray:
    """Of each entry, the how manieth of its row it is, from 0."""
    counts = np.bincount(sorted_rows, minlength=n)
    return np.arange(len(sorted_rows)) - (np.cumsum(counts) - counts)[sorted_rows]


def _rows(codes: IntArray, seen: NDArray[np.complex128]) -> FloatArray:
    return frozen(np.column_stack([codes, seen.real, seen.imag]))
