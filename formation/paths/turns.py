"""Where a path turns more tightly than a formation can: on a radius below its reach.

A slot on the inside of such a turn would have to go backwards, and one on the outside several times as fast.
"""

import math
from typing import NamedTuple

import numpy as np

from formation.arrays import FloatArray
from formation.metrics import wrapped
from formation.paths.path import Path, heading
from formation.paths.waypoints import Waypoints

TOLERANCE = 1.05
"""A radius may be below the reach by so much."""
COARSE = 0.05
"""Step on which a smooth path is looked at [s]."""
SPIKE = 150.0
"""Two legs that turn back by more than this [degrees] ..."""
SHARP = 0.1
"""... on a radius below this share of the reach are a spike, ..."""
RETRACED = 1e-3
"""... unless the second leg goes back over the first [degrees]."""


class Turn(NamedTuple):
    """A part of a path on which it turns too tightly."""

    at: float
    """Time at which it is passed [s]."""
    place: str
    """For the user."""
    angle: float
    """By how much it turns there [rad]."""
    radius: float
    """The least [m]."""


def tight_turns(path: Path, *, reach: float, interval: float, step: float, until: float) -> list[Turn]:
    """Parts of the path up to a time that turn on a smaller radius than the formation's reach.

    Args:
        path: of the formation's centre.
        reach: distance of the outermost slot from the centre [m].
        interval: over which the paper samples the path's heading [s].
        step: on which the path is looked at unless it is smooth [s].
        until: the last time [s].
    """
    step = max(step, COARSE) if path.smooth else step
    t = np.arange(0.0, until + step, step)
    position, theta = path.position(t), np.unwrap(heading(path, t, interval))
    ways, turns = np.hypot(*np.diff(position, axis=0).T), np.diff(theta)
    tight = np.abs(turns) * reach > TOLERANCE * ways + 1e-12
    for at, _ in path.corners:
        tight &= (t[1:] < at) | (t[:-1] > at + interval)
    whole = np.concatenate([[0.0], np.cumsum(ways)])
    found = []
    for first, last in _parts(tight, whole, reach):
        part = slice(first, last + 1)
        radius = float(np.min(ways[part] / np.maximum(np.abs(turns[part]), 1e-12)))
        angle = float(np.ptp(theta[first : last + 2]))
        place = _place(path, float(t[first]), float(t[last + 1]), float(whole[first]), angle)
        found.append(Turn(float(t[first]), place, angle, radius))
    return found


def _parts(tight: FloatArray, whole: FloatArray, reach: float) -> list[tuple[int, int]]:
    """First and last steps of the tight parts; those nearer to each other than the reach are one."""
    parts: list[tuple[int, int]] = []
    for index in np.flatnonzero(tight).tolist():
        if parts and whole[index] - whole[parts[-1][1] + 1] <= reach:
            parts[-1] = parts[-1][0], index
        else:
            parts.append((index, index))
    return parts


def _place(path: Path, begin: float, end: float, way: float, angle: float) -> str:
    if not isinstance(path, Waypoints):
        return f"the path turns by {math.degrees(angle):.3g} degrees at t = {begin:.4g} s"
    course = path.course
    ways = path.way(np.array([begin, end]))
    lap = course.travel.length if path.closed else np.inf
    knots, laps = course.travel.at_knots[: len(course.numbers)], ways // lap * lap if path.closed else np.zeros(2)
    slack = 0.2 * course.travel.length / len(knots)
    before = int(np.searchsorted(knots, ways[0] - laps[0] - slack, side="right")) - 1
    after = int(np.searchsorted(knots, ways[1] - laps[1] + slack, side="left"))
    numbers = [int(course.numbers[max(before, 0)]) + 1, int(course.numbers[after % len(knots)]) + 1]
    return f"points {numbers[0]} to {numbers[1]} turn by {math.degrees(angle):.3g} degrees at {way:.3g} m"


def place_at(path: Path, t: float) -> str:
    """Where a path is at time t [s], for the user."""
    if not isinstance(path, Waypoints):
        return f"t = {t:.4g} s"
    course, way = path.course, float(path.way(np.array(t)))
    inside = way % course.travel.length if path.closed else way
    nearest = int(np.abs(course.travel.at_knots[: len(course.numbers)] - inside).argmin())
    return f"near point {course.numbers[nearest] + 1}, at {way:.3g} m"


def spike(path: Path, reach: float) -> str:
    """What is wrong with a path through points that goes into a spike; empty if it does not.

    Only legs longer than the formation's reach count, and only without smoothing.
    """
    if not isinstance(path, Waypoints) or path.smoothing > 0.0:
        return ""
    course = path.course
    points, count = course.points, len(course.points)
    around = np.vstack([points[-1:], points, points[:1]]) if path.closed else points
    legs = np.diff(around, axis=0)
    lengths, directions = np.hypot(*legs.T), np.arctan2(legs[:, 1], legs[:, 0])
    angles = np.degrees(np.abs(wrapped(np.diff(directions))))
    radii = course.travel.curve.radii[:count] if path.closed else course.travel.curve.radii[1:-1]
    sharp = (angles > SPIKE) & (angles < 180.0 - RETRACED) & (np.minimum(lengths[1:], lengths[:-1]) > reach)
    sharp &= radii < SHARP * reach
    if not sharp.any():
        return ""
    index = int(sharp.argmax()) + (0 if path.closed else 1)
    numbers = [int(course.numbers[(index + shift) % count]) + 1 for shift in (-1, 1)]
    return (
        f"points {numbers[0]} to {numbers[1]} turn by {angles[sharp.argmax()]:.4g} degrees at "
        f"{course.travel.at_knots[index]:.3g} m, on a radius of {radii[sharp.argmax()]:.2g} m; "
        f"expected a path that a formation with a reach of {reach:.2g} m can follow, such as with smoothing = 0.05"
    )
