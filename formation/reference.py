"""The reference on the ticks of the control interval: the centre's path and every robot's feasible slot.

A slot is p_r(t) + Rot(phi(t)) o_i(t), where phi is the formation's orientation and o_i the robot's offset. Its heading
and input follow from its own motion, not the centre's, so that on a curve all errors can be zero at once
(docs/theory.md, section 8). Tables are made a block of ticks at a time, because looking up a row is a thousand times
cheaper than computing it.
"""

from dataclasses import dataclass

import numpy as np

from formation.arrays import FloatArray, timeline
from formation.metrics import wrapped
from formation.offsets import Offsets
from formation.orientation import Orientation
from formation.paths.path import Path, heading
from formation.pattern import rotate

BLOCK_TICKS = 2000
"""Ticks per block: 20 s, computed in some milliseconds."""

HORIZONS = 2
"""Horizons that a block reaches beyond its last tick: a robot that catches up looks further ahead than one."""

SLOW = 1e-3
"""Speed [m/s] below which a slot's direction of motion is noise: its heading then turns towards the path's."""

DERIVATIVE_STEP = 1e-4
"""Half step [s] of the central difference for a slot's velocity; its error is far below a micrometre a second."""


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
        path: Path,
        offsets: Offsets,
        orientation: Orientation,
        *,
        control_interval: float,
        stride: int,
        horizon: int,
    ) -> None:
        """A reference for the robots with these offsets.

        Args:
            path: of the formation's centre.
            offsets: of the robots wanted.
            orientation: which way the formation faces.
            control_interval: delta_t [s], the length of a tick.
            stride: ticks in one prediction interval Delta_T.
            horizon: N, prediction intervals that are looked ahead.
        """
        self._path, self._offsets, self._orientation = path, offsets, orientation
        self._tick, self._stride, self._ahead = control_interval, stride, HORIZONS * stride * horizon
        self._block: Block | None = None

    def block(self, k: int) -> Block:
        """The block that holds ticks k .. k + HORIZONS * stride * horizon."""
        first = k - k % BLOCK_TICKS
        if self._block is None or self._block.first != first:
            self._block = self._rows(first, BLOCK_TICKS + self._ahead + 1)
        return self._block

    def positions(self, t: FloatArray) -> FloatArray:
        """Where the slots are at times t: (T, n, 2) [m]."""
        turned = rotate(self._orientation.angle(t)[:, None], self._offsets.at(t))
        return self._path.position(t)[:, None] + turned

    def _rows(self, first: int, count: int) -> Block:
        interval = self._stride * self._tick
        t = timeline(first, first + count + self._stride, self._tick)
        centre, theta = self._path.position(t), heading(self._path, t, interval)
        moved = centre[self._stride :] - centre[: -self._stride]
        turned = wrapped(theta[self._stride :] - theta[: -self._stride])
        slots = self._slots(t, interval)
        return Block(
            first,
            np.column_stack(
                [centre[:count], theta[:count], np.hypot(moved[:, 0], moved[:, 1]) / interval, turned / interval]
            ),
            np.ascontiguousarray(slots[:count]),
            _inputs(slots[: -self._stride], slots[self._stride :], interval),
        )

    def _slots(self, t: FloatArray, interval: float) -> FloatArray:
        """Slot poses (T, n, 3) at times t."""
        theta = heading(self._path, t, interval)[:, None]
        velocity = (self.positions(t + DERIVATIVE_STEP) - self.positions(t - DERIVATIVE_STEP)) / (2 * DERIVATIVE_STEP)
        body = rotate(-theta, velocity)
        # A slot that moves backwards keeps its heading within pi/2 of the path's and has v < 0.
        drift = np.arctan(body[..., 0] * body[..., 1] / (body[..., 0] ** 2 + SLOW**2))
        return np.concatenate([self.positions(t), (theta + drift)[..., None]], axis=-1)


def _inputs(now: FloatArray, later: FloatArray, interval: float) -> FloatArray:
    """Inputs (T, n, 2) whose arcs lead from slot poses `now` to slot poses `later`."""
    turn = wrapped(later[..., 2] - now[..., 2])
    middle = now[..., 2] + turn / 2.0
    gap = later[..., :2] - now[..., :2]
    along = np.cos(middle) * gap[..., 0] + np.sin(middle) * gap[..., 1]
    return np.stack([along / np.sinc(turn / (2.0 * np.pi)), turn], axis=-1) / interval
