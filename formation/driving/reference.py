"""The reference of a driven formation, by the orders so far: as formation/reference.py has it of a known path."""

import numpy as np

from formation.arrays import FloatArray
from formation.driving.law import Law, Order
from formation.driving.track import Track
from formation.offsets import Offsets
from formation.reference import Block, block_of
from formation.slot_motion import places_along, slots_along


class DrivenReference:
    """The slots of some robots along a track, to which orders may be added."""

    def __init__(self, track: Track, offsets: Offsets, *, stride: int, horizon: int) -> None:
        """The reference along a track.

        Args:
            track: of the formation's centre, from tick 0 on.
            offsets: of the robots wanted.
            stride: ticks in one prediction interval.
            horizon: N.
        """
        self.track, self._offsets = track, offsets
        self._tick, self._stride, self._ahead = track.law.tick, stride, stride * horizon
        self._block: Block | None = None

    def order(self, k: int, order: Order) -> None:
        """Give an order that counts from tick k on, which is not before the newest order's."""
        self.track.order(k, order)
        self._block = None

    def reshape(self, k: int, offsets: Offsets, law: Law) -> None:
        """From tick k on other offsets and another law hold; before it they are the same."""
        self._offsets = offsets
        self.track.obey(k, law)
        self._block = None

    def block(self, k: int) -> Block:
        """A block that holds ticks k .. k + stride * horizon, if no other order is given."""
        block = self._block
        if block is None or not block.first <= k <= block.first + self._ahead:
            first, count = max(k, 0), 2 * self._ahead + 1
            ticks: FloatArray = np.arange(first - 1, first + count + self._stride + 1, dtype=float)
            rows = self.track.rows(ticks)
            slots = slots_along(rows, self._offsets, self._tick)
            interval = self._stride * self._tick
            block = self._block = block_of(first, rows[1:-1, 1:3], rows[1:-1, 3], slots, self._stride, interval)
        return block

    def positions(self, t: FloatArray) -> FloatArray:
        """Positions of the slots at times t of whole ticks: (T, n, 2) [m]."""
        return places_along(self.track.rows(np.rint(t / self._tick)), self._offsets)

    def centre(self, t: FloatArray) -> FloatArray:
        """Positions of the formation's centre at times t of whole ticks: (T, 2) [m]."""
        return self.track.rows(np.rint(t / self._tick))[:, 1:3]

    def lag(self, t: float) -> float:
        """Never late: orders are within what the robots can do."""
        return 0.0

    def preview(self, k: int) -> FloatArray:
        """One horizon from tick k on, if no other order is given; rows as in formation/way.py."""
        return self.track.preview(k, self._stride, self._ahead // self._stride)
