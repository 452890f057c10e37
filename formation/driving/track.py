"""Where the centre of a driven formation is at every tick, by the orders so far."""

from typing import NamedTuple

import numpy as np

from formation.arrays import FloatArray
from formation.driving.law import REST, Centre, Law, Order

KEPT = 10_000
"""Ticks that are kept at least where the past is dropped."""


class Dated(NamedTuple):
    """An order, and the tick from which on it counts."""

    tick: int
    order: Order


class Track:
    """The centre from a tick on. An order for tick k changes what is after k, and nothing before."""

    def __init__(self, law: Law, first: int, start: Centre, order: Order = REST) -> None:
        """A track of one order.

        Args:
            law: of the motion.
            first: its first tick.
            start: the centre then.
            order: that counts then.
        """
        self.law, self.first = law, first
        self.orders = [Dated(first, order)]
        """The newest last; there is always one."""
        self._rows = np.empty((1024, len(start)))
        self._rows[0] = start
        self._last, self._newest = first, start

    def order(self, k: int, order: Order) -> None:
        """Give an order that counts from tick k on, which is not before the newest order's."""
        self._reach(k)
        if self._last > k:
            self._last, self._newest = k, Centre(*self._rows[k - self.first].tolist())
        if self.orders[-1].tick == k:
            self.orders.pop()
        self.orders.append(Dated(k, order))

    def obey(self, k: int, law: Law) -> None:
        """From tick k on another law holds."""
        self.order(k, self.orders[-1].order)
        self.law = law

    def at(self, k: int) -> Centre:
        """The centre at tick k."""
        self._reach(k)
        return Centre(*self._rows[max(k - self.first, 0)].tolist())

    def rows(self, ticks: FloatArray) -> FloatArray:
        """Path time, x, y, heading and facing (T, 5) at whole ticks (T,); before the first as at the first."""
        self._reach(int(ticks.max(initial=0.0)))
        found = self._rows[np.maximum(ticks.astype(int) - self.first, 0), :4]
        return np.column_stack([self.law.tick * ticks, found])

    def preview(self, k: int, stride: int, horizon: int) -> FloatArray:
        """One horizon from tick k on, (horizon + 1, 6) as in formation/way.py, if no other order is given."""
        ticks: FloatArray = k + stride * np.arange(horizon + 1, dtype=float)
        return np.column_stack([ticks, self.rows(ticks)])

    def forget(self, k: int) -> None:
        """Drop what is before tick k: a run may go on for ever."""
        if k - self.first > KEPT:
            kept = self._rows[k - self.first : self._last + 1 - self.first].copy()
            if len(kept):
                self._rows, self.first = np.concatenate([kept, np.empty((KEPT, kept.shape[1]))]), k
                self.orders = self.orders[-1:]

    def _reach(self, k: int) -> None:
        """Have rows up to tick k, by the newest order."""
        if k <= self._last:
            return
        while k - self.first >= len(self._rows):
            self._rows = np.concatenate([self._rows, np.empty_like(self._rows)])
        now, order, step, rows, first = self._newest, self.orders[-1].order, self.law.next, self._rows, self.first
        for tick in range(self._last + 1, k + 1):
            now = step(now, order)
            rows[tick - first] = now
        self._last, self._newest = k, now
