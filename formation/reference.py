"""The reference on the ticks of the control interval: the centre's path and every robot's feasible slot.

It is the motion of the slots (formation/slot_motion.py) at the pace that robots can follow
(formation/schedule.py). Tables are made a block of ticks at a time, because looking up a row is a thousand times
cheaper than computing it.
"""

from dataclasses import dataclass

import numpy as np

from formation.arrays import FloatArray, timeline
from formation.metrics import wrapped
from formation.schedule import Schedule
from formation.slot_motion import Motion

BLOCK_TICKS = 2000
"""Ticks per block: 20 s, computed in some milliseconds."""

BEHIND_TICKS = 1100
"""Ticks before its first one that a block reaches back to: measurements and reference times that are late."""

KEPT_BLOCKS = 3
"""Blocks that are kept: one around now, and those around reference times that are late."""

HORIZONS = 2
"""Horizons that a block reaches beyond its last tick: a robot that catches up looks further ahead than one."""


@dataclass(frozen=True, slots=True)
class Block:
    """Rows of the reference for BLOCK_TICKS ticks, BEHIND_TICKS before them and HORIZONS horizons more."""

    first: int
    """Tick of row 0."""
    centre: FloatArray
    """(T, 5): x_r, y_r, theta_r, v_r, omega_r of the formation's centre [m, m, rad, m/s, rad/s]."""
    slots: FloatArray
    """(T, n, 3): pose of every robot's slot [m, m, rad]."""
    inputs: FloatArray
    """(T, n, 2): v, omega that take a slot's pose to that of one prediction interval later [m/s, rad/s]."""


class Reference:
    """The reference of some robots, by tick. `block(k)` holds every tick from k to HORIZONS horizons on."""

    def __init__(
        self,
        motion: Motion,
        schedule: Schedule,
        *,
        control_interval: float,
        stride: int,
        horizon: int,
    ) -> None:
        """A reference for some robots.

        Args:
            motion: of their slots.
            schedule: of all robots.
            control_interval: delta_t [s], the length of a tick.
            stride: ticks in one prediction interval Delta_T.
            horizon: N, prediction intervals that are looked ahead.
        """
        self._motion, self._schedule = motion, schedule
        self._tick, self._stride, self._ahead = control_interval, stride, HORIZONS * stride * horizon
        self._blocks: dict[int, Block] = {}
        if motion.robots is None:
            motion.course.everybody = self

    def block(self, k: int) -> Block:
        """The block that holds ticks k .. k + HORIZONS * stride * horizon."""
        start = k - k % BLOCK_TICKS
        block = self._blocks.get(start)
        if block is None:
            if len(self._blocks) >= KEPT_BLOCKS:
                del self._blocks[min(self._blocks)]
            block = self._blocks[start] = self._made(start)
        return block

    def _made(self, start: int) -> Block:
        """The block that begins at this tick; of some robots from that of all, where this process has it."""
        everybody, robots = self._motion.course.everybody, self._motion.robots
        if everybody is not None and robots is not None:
            block: Block = everybody.block(start)
            rows = [robot - 1 for robot in robots]
            return Block(block.first, block.centre, block.slots.take(rows, axis=1), block.inputs.take(rows, axis=1))
        first = max(0, start - BEHIND_TICKS)
        return self._rows(first, start - first + BLOCK_TICKS + self._ahead + 1)

    def positions(self, t: FloatArray) -> FloatArray:
        """Positions of the slots at times t: (T, n, 2) [m]."""
        return self._motion.positions(self._schedule.path_time(t))

    def centre(self, t: FloatArray) -> FloatArray:
        """Positions of the formation's centre at times t: (T, 2) [m]."""
        return self._motion.centre(self._schedule.path_time(t))[0]

    def lag(self, t: float) -> float:
        """How late all robots are at time t, because they could not follow otherwise [s]."""
        return self._schedule.lag(t)

    def preview(self, k: int) -> FloatArray:
        """What robot 1 tells the others of the path at tick k: one horizon of rows as in formation/way.py."""
        ticks = k + self._stride * np.arange(self._ahead // (HORIZONS * self._stride) + 1)
        clock: FloatArray = self._tick * ticks.astype(float)
        t = self._schedule.path_time(clock)
        centre, theta = self._motion.centre(t)
        return np.column_stack([ticks, t, centre, theta, self._motion.facing(t)])

    def _rows(self, first: int, count: int) -> Block:
        t = self._schedule.path_time(timeline(first, first + count + self._stride, self._tick))
        centre, theta = self._motion.centre(t)
        return block_of(first, centre, theta, self._slots(t), self._stride, self._stride * self._tick)

    def _slots(self, t: FloatArray) -> FloatArray:
        """Slot poses (T, n, 3) at path times t (T,); within a slow step the headings turn steadily."""
        slots = self._motion.poses(t)
        begin, slow = self._schedule.slow(t)
        if slow.any():
            begin, step = begin[slow], self._schedule.step
            before, after = self._motion.poses(begin)[..., 2], self._motion.poses(begin + step)[..., 2]
            share = ((t[slow] - begin) / step)[:, None]
            slots[slow, :, 2] = before + share * wrapped(after - before)
        return slots


def block_of(
    first: int, centre: FloatArray, theta: FloatArray, slots: FloatArray, stride: int, interval: float
) -> Block:
    """The block that begins at tick `first`, and ends `stride` ticks before what is given.

    Args:
        first: its first tick.
        centre: (T + stride, 2) of the formation [m].
        theta: (T + stride,) heading of the path [rad].
        slots: (T + stride, n, 3) [m, m, rad].
        stride: ticks in one prediction interval.
        interval: the same in seconds.
    """
    count = len(slots) - stride
    moved = centre[stride:] - centre[:-stride]
    turned = wrapped(theta[stride:] - theta[:-stride])
    speed = np.hypot(moved[:, 0], moved[:, 1]) / interval
    path = np.empty((count, 5))
    path[:, :2], path[:, 2], path[:, 3] = centre[:count], theta[:count], speed
    np.divide(turned, interval, out=path[:, 4])
    return Block(
        first,
        path,
        np.ascontiguousarray(slots[:count]),
        _inputs(slots[:-stride], slots[stride:], interval),
    )


def _inputs(now: FloatArray, later: FloatArray, interval: float) -> FloatArray:
    """Inputs (T, n, 2) whose arcs lead from slot poses `now` to slot poses `later`."""
    turn = wrapped(later[..., 2] - now[..., 2])
    middle = now[..., 2] + turn / 2.0
    gap = later[..., :2] - now[..., :2]
    along = np.cos(middle) * gap[..., 0] + np.sin(middle) * gap[..., 1]
    found = np.empty((*turn.shape, 2))
    found[..., 0] = along / np.sinc(turn / (2.0 * np.pi))
    found[..., 1] = turn
    found /= interval
    return found
