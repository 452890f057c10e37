"""Random draws by counter: key (seed, stream and robot), counter (block of ticks). A draw depends on nothing else.

A block of ticks is drawn at a time, because starting a generator costs more than a thousand draws. A block's numbers
depend on seed, stream, robot and block only: not on how many robots there are, on which other noise is on, or on what
was asked for before.
"""

from typing import Any, Final

import numpy as np

from formation.arrays import FloatArray

BLOCK: Final = 1024
"""Ticks per block."""
MOTION, LOCALISATION, OUTLIER, RELATIVE, CONSTANT, CHANCE, GUST, SIGHT = 2, 3, 4, 5, 6, 7, 8, 9
"""Streams: slip and gyro, localisation's noise, the size of outliers, relative sensing, a robot's constants,
whether a measurement is an outlier, gusts, and sight. (Stream 1 is the start poses'.)"""


def generator(seed: int, stream: int, robot: int, block: int = 0) -> np.random.Generator:
    """The generator of one block of one robot (row, from 0) in one stream."""
    return np.random.Generator(np.random.Philox(key=[seed, stream << 32 | robot], counter=[0, 0, block, 0]))


class Draws:
    """Standard normal (or uniform) draws of one stream for all robots, by tick."""

    def __init__(
        self, seed: int, stream: int, robots: int, width: int, *, uniform: bool = False, ticks: int = BLOCK
    ) -> None:
        """Draws (robots, width) a tick, so many ticks at a time; `uniform` ones come from [0, 1)."""
        self._seed, self._stream, self._robots, self._width = seed, stream, robots, width
        self._uniform, self._ticks = uniform, ticks
        self._block = -1
        self._rows: FloatArray = np.empty(0)

    def __getstate__(self) -> dict[str, Any]:
        """All but the block that is drawn: it can be drawn again."""
        return {**self.__dict__, "_block": -1, "_rows": np.empty(0)}

    def at(self, tick: int) -> FloatArray:
        """(robots, width) of this tick."""
        block, row = divmod(tick, self._ticks)
        if block != self._block:
            self._block = block
            self._rows = np.stack([self._drawn(robot, block) for robot in range(self._robots)], axis=1)
        drawn: FloatArray = self._rows[row]
        return drawn

    def _drawn(self, robot: int, block: int) -> FloatArray:
        source = generator(self._seed, self._stream, robot, block)
        size = (self._ticks, self._width)
        return source.random(size) if self._uniform else source.standard_normal(size)
