"""The reference on the ticks of the control interval: the centre's path and every robot's feasible slot.

It is the motion of the slots (formation/motion.py) at the pace that robots can follow (formation/schedule.py). Tables
are made a block of ticks at a time, because looking up a row is a thousand times cheaper than computing it.
"""

from dataclasses import dataclass

import numpy as np

from formation.arrays import FloatArray, timeline
from formation.metrics import wrapped
from formation.motion import Motion
from formation.schedule import Schedule

BLOCK_TICKS = 2000
"""Ticks per block: 20 s, computed in some milliseconds."""

HORIZONS = 2
"""Horizons that a block reaches beyond its last tick: a robot that catches up looks further ahead than one."""


@dataclass(frozen=True, slots=True)
class Block:
    """Rows of the reference for ticks first .. first + BLOCK_TICKS and HORIZONS horizons more."""

    first: int
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
        self._block: Block | None = None

    def block(self, k: int) -> Block:
        """The block that holds ticks k .. k + HORIZONS * stride * horizon."""
        first = k - k % BLOCK_TICKS
        if self._block is None or self._block.first != first:
            self._block = self._rows(first, BLOCK_TICKS + self._ahead + 1)
        return self._block

    def positions(self, t: FloatArray) -> FloatArray:
        """Positions of the slots at times t: (T, n, 2) [m]."""
        return self._motion.positions(self._schedule.path_time(t))

    def centre(self, t: FloatArray) -> FloatArray:
        """Positions of the formation's centre at times t: (T, 2) [m]."""
        return self._motion.centre(self._schedule.path_time(t))[0]

    def lag(self, t: float) -> float:
        """How late all robots are at time t, because they could not follow otherwise [s]."""
        return self._schedule.lag(t)

    def _rows(self, first: int, count: int) -> Block:
        interval = self._stride * self._tick
        t = self._schedule.path_time(timeline(first, first + count + self._stride, self._tick))
        centre, theta = self._motion.centre(t)
        moved = centre[self._stride :] - centre[: -self._stride]
        turned = wrapped(theta[self._stride :] - theta[: -self._stride])
        slots = self._slots(t)
        return Block(
            first,
            np.column_stack(
                [centre[:count], theta[:count], np.hypot(moved[:, 0], moved[:, 1]) / interval, turned / interval]
            ),
            np.ascontiguousarray(slots[:count]),
            _inputs(slots[: -self._stride], slots[self._stride :], interval),
        )

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


def _inputs(now: FloatArray, later: FloatArray, interval: float) -> FloatArray:
    """Inputs (T, n, 2) whose arcs lead from slot poses `now` to slot poses `later`."""
    turn = wrapped(later[..., 2] - now[..., 2])
    middle = now[..., 2] + turn / 2.0
    gap = later[..., :2] - now[..., :2]
    along = np.cos(middle) * gap[..., 0] + np.sin(middle) * gap[..., 1]
    return np.stack([along / np.sinc(turn / (2.0 * np.pi)), turn], axis=-1) / interval
