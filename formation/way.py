"""The reference of robots that do not know the path, from the previews of those that do (docs/theory.md, section 17).

Robot 1 sends where the formation's centre will be over one horizon; the others pass the newest preview on. A robot
builds its slots from it as formation/slot_motion.py does from the path. Beyond the preview it goes on along an arc, and
stops when the preview has been over for long. A newer preview then leads back without a jump: the gap between the two
references fades like a critically damped spring.
"""

import math
from collections.abc import Sequence
from functools import cache

import numpy as np

from formation.arrays import FloatArray, IntArray
from formation.clear.detour import Detour
from formation.metrics import wrapped
from formation.offsets import Offsets
from formation.pattern import rotate
from formation.reference import BEHIND_TICKS, BLOCK_TICKS, Block, block_of
from formation.slot_motion import slots_along

TICK, TIME, X, Y, THETA, FACING = range(6)
"""Columns of a preview, (m, 6); its rows are one prediction interval apart."""
HOLD, BRAKE = 1.0, 1.0
"""How long a robot drives on beyond its preview, and how long it then takes to stop [s]."""
TURN = 1.0
"""The arc beyond a preview turns no faster, though a corner were its end [rad/s]."""
RETURN = 1.5
"""Rate at which the gap to a newer preview closes [1/s]."""
SHARE = 0.4
"""Of the robots' largest speed, with which a slot returns over a wide gap: who cannot follow leaves the formation."""
SPARE = 50
"""Ticks that are computed beyond those that are asked for, while nothing is heard."""
CLOSED = 1e-6
"""A gap below this is none [m, rad, s]."""
BACK = 0.005
"""A robot that is this near to the place that its newest preview gives it is not lost any more [m]."""


class HeardReference:
    """The reference of some robots by tick, as Reference; but from what was heard, so it changes when more is heard."""

    def __init__(
        self,
        offsets: Offsets,
        start: FloatArray,
        *,
        control_interval: float,
        stride: int,
        horizon: int,
        v_max: float,
        ring: Sequence[int],
        revised: bool = False,
    ) -> None:
        """A robot that knows the preview with which the episode begins.

        Args:
            offsets: of the robots wanted.
            start: preview with which it begins.
            control_interval: delta_t [s].
            stride: ticks in one prediction interval.
            horizon: N.
            v_max: limit of the robots' speed [m/s].
            ring: robots as previews pass from one to the next, who knows the path first (numbers, from 1).
            revised: whether a preview may differ from the ones before it where they overlap: the path is driven.
        """
        self._offsets, self._tick, self._stride, self._revised = offsets, control_interval, stride, revised
        self._ahead = stride * (horizon + 1)
        self._cubics = _cubics(stride, len(start))
        self._ways = _ways_beyond(control_interval)
        self._speed, self._reach = SHARE * v_max, offsets.reach
        self._joined, self._gap, self._slope, self._rate = 0, np.zeros(5), np.zeros(5), RETURN
        self._returning, self._detour, self._via = False, Detour(ring), np.zeros(2)
        self._take(start)
        self.known = True
        """Whether there is anything to follow."""
        self._filled = 0
        self._block = self._empty(0)
        self._fill(0, self._ahead)

    @property
    def end(self) -> int:
        """Tick at which the newest preview ends."""
        return int(self.newest[-1, TICK])

    def lost(self, k: int) -> bool:
        """Whether at tick k the preview is over, or a newer one is not reached yet."""
        if k > self.end or not self._returning:
            return k > self.end
        gap = self._gap_at(np.array([k]))[0, X - 1 : Y] + self._via
        return math.hypot(*gap) > BACK

    def forget(self) -> None:
        """Nothing is known: the robot begins in the middle of an episode."""
        self.known = False

    def hear(self, preview: FloatArray, k: int, late: int = 0, first: int = 0) -> bool:
        """Take a preview at tick k, if it is newer than what is known.

        Args:
            preview: (m, 6) that was heard.
            k: when the next command acts.
            late: ticks that the robot's reference time is behind; from k - late on the preview counts.
            first: of the robots that are lost, as far as this one knows; 0 if it knows nothing of others.

        Returns:
            Whether it was taken.
        """
        if preview.shape != self.newest.shape or preview[0, TICK] <= self.newest[0, TICK]:
            return False
        steps = preview[1:, TICK] - preview[:-1, TICK]
        if np.any(steps != self._stride) or not 0 <= preview[0, TICK] <= k:
            return False
        k = max(k - late, int(preview[0, TICK])) if late else k
        if k > self._filled:
            self._fill(self._filled, k)
        whole, old_end = self.known and not self._returning, self.end
        before = self._centre(k, k + 2)
        self._take(preview)
        self._joined, self._gap, self._slope = k, np.zeros(5), np.zeros(5)
        self._returning, self._via = False, np.zeros(2)
        if self.known:
            here = self._centre(k, k + 2)
            apart = before - here
            turns = slice(THETA - 1, None)
            apart[:, turns] = wrapped(apart[:, turns])
            if np.abs(apart).max() > CLOSED:
                self._go_round(here[0], apart[0], first)
                apart[:, X - 1 : Y] -= self._via
                self._gap = apart[0]
                self._rate = min(RETURN, 2.0 * self._speed / max(self._farthest(apart[0]), CLOSED))
                self._slope = apart[1] * math.exp(self._rate * self._tick) - apart[0]
                self._returning = True
        self.known = True
        # What both previews have stays, unless a gap was closed or is to be.
        same = whole and not self._returning and not self._revised
        self._fill(min(max(k, old_end - 3 * self._stride), self._filled) if same else k, k + self._ahead)
        return True

    def reshape(self, k: int, offsets: Offsets) -> None:
        """From tick k on other offsets hold; before it they are the same."""
        self._offsets = offsets
        if k < self._filled:
            self._fill(k, self._filled)

    def block(self, k: int) -> Block:
        """The block that holds ticks k .. k + stride * (horizon + 1). It changes with what is heard."""
        if k + self._ahead > self._filled:
            self._fill(self._filled, k + self._ahead + SPARE)
        return self._block

    def preview(self, k: int) -> FloatArray:
        """What the robot passes on: the newest preview that it knows, (m, 6), empty if none."""
        return self.newest if self.known else self.newest[:0]

    def age(self, k: int) -> float:
        """How long ago robot 1 sent what is known at tick k [s]."""
        return max(0.0, k - float(self.newest[0, TICK])) * self._tick

    def _take(self, preview: FloatArray) -> None:
        self.newest = preview
        self._nodes = preview[:, TIME:].copy()
        turns = self._nodes[:, THETA - 1 :]
        if np.abs(turns[1:] - turns[:-1]).max() >= math.pi:
            turns[:] = np.unwrap(turns, axis=0)

    def _go_round(self, here: FloatArray, gap: FloatArray, first: int) -> None:
        """Choose the point by way of which a gap (5,) closes, where the formation is here (5,): `_via` (2,) [m]."""
        every = self._offsets.every.after(float(here[TIME - 1]))
        facing, turn = here[FACING - 1], float(gap[FACING - 1])
        own = rotate(-facing, gap[X - 1 : Y])
        via = self._detour.via(every, first, own, turn)
        if via.any():
            way = via - own
            via = own + way * max(1.0, 2.0 * self._speed / RETURN / max(math.hypot(*way), CLOSED))
            self._via = rotate(facing, via)

    def _gap_at(self, ticks: FloatArray) -> FloatArray:
        """What is left of the gap (T, 5) at these ticks (T,)."""
        passed = (ticks - self._joined)[:, None]
        return (self._gap + self._slope * passed) * np.exp(-self._rate * self._tick * passed)

    def _farthest(self, gap: FloatArray) -> float:
        """How far a slot is from its place by a gap (5,), at most [m]."""
        return math.hypot(gap[X - 1], gap[Y - 1]) + self._reach * abs(float(gap[FACING - 1]))

    def _centre(self, begin: int, end: int) -> FloatArray:
        """Path time, x, y, path's heading and facing (T, 5) at ticks begin .. end - 1: preview, arc beyond, and gap."""
        found = np.empty((end - begin, 5))
        over = max(begin, self.end + 1)
        if over > begin:
            self._inside(begin, min(end, over), found[: over - begin])
        if over < end:
            self._beyond(over - self.end, end - self.end, found[over - begin :])
        if self._returning:
            found += self._gap_at(np.arange(begin, end, dtype=float))
            found[:, X - 1 : Y] += self._via
        return found

    def _inside(self, begin: int, end: int, found: FloatArray) -> None:
        """Cubics through the preview's rows, (T, 5) at ticks begin .. end - 1, of which none is beyond it."""
        nodes, weights = self._cubics
        first = int(self.newest[0, TICK])
        rows: slice | IntArray = slice(begin - first, end - first)
        if begin < first:
            rows = np.maximum(np.arange(begin - first, end - first), 0)
        parts = self._nodes[nodes[rows]]
        parts *= weights[rows]
        np.subtract(parts[:, 1], parts[:, 0], out=found)
        found -= parts[:, 2]
        found += parts[:, 3]

    def _beyond(self, begin: int, end: int, found: FloatArray) -> None:
        """Along the arc of the preview's last two intervals, and to a stop; (T, 5) from tick to tick after its end."""
        nodes, interval = self._nodes, self._stride * self._tick
        rows: slice | IntArray = slice(begin, end)
        if end > len(self._ways):
            rows = np.minimum(np.arange(begin, end), len(self._ways) - 1)
        s = self._ways[rows]
        chords = nodes[-2:, X - 1 : Y] - nodes[-3:-1, X - 1 : Y]
        angles = np.arctan2(chords[:, 1], chords[:, 0])
        most = TURN * interval
        turn = min(max(float(wrapped(angles[1:] - angles[:1])[0]), -most), most)
        step = nodes[-1] - nodes[-2]
        step[THETA - 1 :] = np.minimum(np.maximum(step[THETA - 1 :], -most), most)
        speed = math.hypot(*chords[1]) / (interval * np.sinc(turn / (2.0 * np.pi)))
        half = turn * s / (2.0 * interval)
        direction = angles[1] + turn / 2.0 + half
        way = speed * s * np.sinc(half / np.pi)
        np.multiply((s / interval)[:, None], step, out=found)
        found += nodes[-1]
        found[:, X - 1] = nodes[-1, X - 1] + way * np.cos(direction)
        found[:, Y - 1] = nodes[-1, Y - 1] + way * np.sin(direction)

    def _empty(self, first: int) -> Block:
        rows = BEHIND_TICKS + BLOCK_TICKS
        n = self._offsets.size
        return Block(first, np.zeros((rows, 5)), np.zeros((rows, n, 3)), np.zeros((rows, n, 2)))

    def _fill(self, begin: int, end: int) -> None:
        """Compute the rows of ticks begin .. end - 1 anew."""
        if end - self._block.first > len(self._block.slots):
            first = begin - BEHIND_TICKS
            if end - begin > BLOCK_TICKS:  # it began in the middle of an episode: nobody asks for what was long ago
                first = begin = end - BLOCK_TICKS
            self._move(first)
        centre = self._centre(begin - 1, end + self._stride + 1)
        new = block_of(
            begin,
            centre[1:-1, X - 1 : Y],
            centre[1:-1, THETA - 1],
            slots_along(centre, self._offsets, self._tick),
            self._stride,
            self._stride * self._tick,
        )
        rows = slice(begin - self._block.first, end - self._block.first)
        self._block.centre[rows], self._block.slots[rows], self._block.inputs[rows] = new.centre, new.slots, new.inputs
        self._filled = end

    def _move(self, first: int) -> None:
        """A block that begins later, with the rows that both have."""
        old, self._block = self._block, self._empty(first)
        count = max(0, self._filled - first)
        kept = slice(first - old.first, first - old.first + count)
        for name in ("centre", "slots", "inputs"):
            getattr(self._block, name)[:count] = getattr(old, name)[kept]


@cache
def _cubics(stride: int, rows: int) -> tuple[IntArray, FloatArray]:
    """Lagrange's cubics through the rows of a preview, by ticks after its first, up to its last.

    Args:
        stride: ticks from row to row.
        rows: of a preview, at least 4.

    Returns:
        The four rows (D, 4) around each tick, and their weights (D, 4, 1): those of the second row, less those of the
        first and of the third, and those of the fourth.
    """
    last = rows - 1
    at = np.arange(stride * last + 1) / stride
    j = np.minimum(at.astype(int), last - 1)
    first = np.minimum(np.maximum(j - 1, 0), last - 3)
    u = (at - j) + (j - first)
    a, b, c = u - 1, u - 2, u - 3
    ab, ua, ub = a * b, u * a, u * b
    weights = np.stack([ab * c / 6, ub * c / 2, ua * c / 2, ua * b / 6], axis=-1)
    return first[:, None] + np.arange(4), weights[..., None]


@cache
def _ways_beyond(tick: float) -> FloatArray:
    """Time by which a robot goes on along the arc, by ticks after its preview's end, until it stands [s]."""
    after = np.arange(math.ceil((HOLD + BRAKE) / tick) + 2) * tick
    braking = np.minimum(np.maximum(after - HOLD, 0.0), BRAKE)
    return np.asarray(np.minimum(after, HOLD) + braking - braking**2 / (2.0 * BRAKE))
