"""How the slots move along the path, by path time: before anybody asks whether robots can follow.

A slot is p_r(t) + Rot(phi(t)) o_i(t), where phi is the formation's orientation and o_i the robot's offset. Its heading
follows from its own motion, not the centre's, so that on a curve all errors can be zero at once (docs/theory.md,
section 8).
"""

from collections.abc import Callable
from typing import Any

import numpy as np

from formation.arrays import FloatArray, read_only
from formation.offsets import Offsets
from formation.orientation import Orientation
from formation.paths.path import Path, heading
from formation.pattern import rotate

SLOW = 1e-3
"""Speed [m/s] below which a slot's direction of motion is noise: its heading then turns towards the path's."""

TIME, PLACE, THETA, FACING = 0, slice(1, 3), 3, 4
"""Columns of rows that say where a formation's centre is: path time, x and y, the path's heading, and facing."""
DERIVATIVE_STEP = 1e-4
"""Half step [s] of the central difference for a slot's velocity; its error is far below a micrometre a second."""
LONG, KEPT = 100, 14
"""Answers about so many times are kept, and how many of them: two blocks of a reference are seven each."""


class Course:
    """Where the formation's centre is and which way it faces, by path time.

    It is the same for all robots, whose references ask for it at the same times: the newest answers are kept.
    """

    def __init__(self, path: Path, orientation: Orientation, interval: float) -> None:
        """A formation on its path.

        Args:
            path: of its centre.
            orientation: which way it faces.
            interval: over which the paper samples the path's heading [s].
        """
        self.path, self.interval, self._orientation = path, interval, orientation
        self._answers: dict[tuple[str, bytes], FloatArray] = {}
        self.everybody: Any = None
        """The reference of all robots (formation/reference.py), if somebody has it: whose is of some takes it from
        there."""

    def __getstate__(self) -> dict[str, Any]:
        """All but the answers: they can be computed again."""
        return {**self.__dict__, "_answers": {}, "everybody": None}

    def position(self, t: FloatArray) -> FloatArray:
        """Positions (T, 2) of the path at times t (T,) [m]."""
        return self._kept("position", t, self.path.position)

    def heading(self, t: FloatArray) -> FloatArray:
        """Headings (T,) of the path [rad]."""
        return self._kept("heading", t, lambda t: heading(self.path, t, self.interval))

    def facing(self, t: FloatArray) -> FloatArray:
        """Which way the formation faces, (T,) [rad]."""
        return self._kept("facing", t, self._orientation.angle)

    def _kept(self, what: str, t: FloatArray, made: Callable[[FloatArray], FloatArray]) -> FloatArray:
        if len(t) < LONG:
            return made(t)
        key = what, t.tobytes()
        found = self._answers.get(key)
        if found is None:
            while len(self._answers) >= KEPT:
                del self._answers[next(iter(self._answers))]
            found = self._answers[key] = read_only(made(t).view())
        return found


class Motion:
    """The slots of some robots as functions of path time."""

    def __init__(self, course: Course, offsets: Offsets, robots: list[int] | None = None) -> None:
        """The motion of these robots, of all if None, with their offsets from the formation's centre on its course."""
        self.course, self.path, self.interval, self.offsets = course, course.path, course.interval, offsets
        self.robots = robots

    def centre(self, t: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Positions (T, 2) [m] and headings (T,) [rad] of the path at times t (T,)."""
        return self.course.position(t), self.course.heading(t)

    def facing(self, t: FloatArray) -> FloatArray:
        """Which way the formation faces at times t (T,): (T,) [rad]."""
        return self.course.facing(t)

    def positions(self, t: FloatArray) -> FloatArray:
        """Positions of the slots at times t (T,): (T, n, 2) [m]."""
        turned = rotate(self.course.facing(t)[:, None], self.offsets.at(t))
        return self.course.position(t)[:, None] + turned

    def poses(self, t: FloatArray) -> FloatArray:
        """Poses of the slots at times t (T,): (T, n, 3) [m, m, rad]."""
        theta = self.course.heading(t)[:, None]
        velocity = (self.positions(t + DERIVATIVE_STEP) - self.positions(t - DERIVATIVE_STEP)) / (2 * DERIVATIVE_STEP)
        return np.concatenate([self.positions(t), (theta + _drift(theta, velocity))[..., None]], axis=-1)


def places_along(centre: FloatArray, offsets: Offsets) -> FloatArray:
    """Slot positions (T, n, 2) where the centre is at rows (T, 5) of path time, x, y, heading and facing [m]."""
    return centre[:, None, PLACE] + rotate(centre[:, None, FACING], offsets.at(centre[:, TIME]))


def slots_along(centre: FloatArray, offsets: Offsets, tick: float) -> FloatArray:
    """Slot poses (T, n, 3) of rows (T + 2, 5), a tick apart: where they are, and the direction in which they move."""
    places = places_along(centre, offsets)
    velocity = (places[2:] - places[:-2]) / (2.0 * tick)
    theta = centre[1:-1, None, THETA]
    found = np.empty((*theta.shape[:1], places.shape[1], 3))
    found[..., :2] = places[1:-1]
    np.add(theta, _drift(theta, velocity), out=found[..., 2])
    return found


def _drift(theta: FloatArray, velocity: FloatArray) -> FloatArray:
    """From the path's heading to that of a slot with a velocity (..., 2); within pi/2, also backwards, with v < 0."""
    body = rotate(-theta, velocity)
    turned: FloatArray = np.arctan(body[..., 0] * body[..., 1] / (body[..., 0] ** 2 + SLOW**2))
    return turned
