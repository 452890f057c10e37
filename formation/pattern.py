"""The ring between the robots of a formation, and the pattern of each pair, from offsets in the body frame.

Robots are numbered from 1; row i - 1 of every array belongs to robot i. Robot i receives the plans of its upstream
neighbour i - 1, robot 1 those of the last (Assumption 1 and fig. 1 of the paper).
"""

from collections.abc import Collection
from dataclasses import dataclass

import numpy as np

from formation.arrays import FloatArray, frozen


@dataclass(frozen=True, slots=True)
class Pattern:
    """The desired pattern of every pair (robot i, its upstream neighbour -i); row i - 1 is that of robot i."""

    distance: FloatArray
    """(n,) l_r: distance to the upstream neighbour [m]."""
    angle: FloatArray
    """(n,) psi_offset: psi_r(t) = theta_r(t) + psi_offset [rad]."""
    centre: FloatArray
    """(n, 2) p_v^O: the formation's centre seen from the pair's, in the frame O of the pair [m]."""


def upstream(robot: int, robots: int, away: Collection[int] = ()) -> int:
    """The number of the robot whose plans `robot` receives; the ring closes over those that are away."""
    found = (robot - 2) % robots + 1
    while found in away and found != robot:
        found = (found - 2) % robots + 1
    return found


def downstream(robot: int, robots: int, away: Collection[int] = ()) -> int:
    """The number of the robot that receives the plans of `robot`; the ring closes over those that are away."""
    found = robot % robots + 1
    while found in away and found != robot:
        found = found % robots + 1
    return found


def leader(away: Collection[int], *, follows: bool) -> int:
    """The number of the robot that knows the path where one alone does: robot 1, or the next that has not left.

    Args:
        away: robots that have left the ring.
        follows: whether another one takes the path over.
    """
    found = 1
    while follows and found in away:
        found += 1
    return found


def ring_from(first: int, robots: int, away: Collection[int] = ()) -> list[int]:
    """The robots of the ring, one downstream of the other, from a robot on."""
    return [robot for robot in (*range(first, robots + 1), *range(1, first)) if robot not in away]


def neighbours(robot: int, robots: int, away: Collection[int] = ()) -> tuple[int, int, int]:
    """The robot upstream, the one upstream of that, and the one downstream."""
    other = upstream(robot, robots, away)
    return other, upstream(other, robots, away), downstream(robot, robots, away)


def place(robot: int, robots: int, away: Collection[int] = ()) -> tuple[bool, int, int, int]:
    """The robot's place in the ring: whether it is away, and its neighbours."""
    return robot in away, *neighbours(robot, robots, away)


def pattern(offsets: FloatArray) -> Pattern:
    """Pattern of every pair, from offsets (n, 2) in the body frame (x forward, y left, mean zero) [m]."""
    return between(offsets, np.roll(offsets, 1, axis=0))


def between(own: FloatArray, other: FloatArray) -> Pattern:
    """Pattern of pairs: robots with offsets own (n, 2), their upstream neighbours with offsets other (n, 2) [m].

    d = o_-i - o_i;  l_r = |d|;  psi_offset = atan2(-d_x, d_y);  p_v^O = Rot(psi_offset)^T (-(o_i + o_-i)/2).
    """
    d = other - own
    angle = np.arctan2(-d[:, 0], d[:, 1])
    middle = -(own + other) / 2.0
    c, s = np.cos(angle), np.sin(angle)
    centre = np.stack([c * middle[:, 0] + s * middle[:, 1], -s * middle[:, 0] + c * middle[:, 1]], axis=1)
    return Pattern(frozen(np.hypot(d[:, 0], d[:, 1])), frozen(angle), frozen(centre))


def rotate(angle: FloatArray, vectors: FloatArray) -> FloatArray:
    """Rot(angle) vectors: angle of shape (...), vectors of shape (..., 2), broadcast against each other."""
    c, s = np.cos(angle), np.sin(angle)
    x, y = vectors[..., 0], vectors[..., 1]
    along = c * x - s * y
    found = np.empty((*along.shape, 2))
    found[..., 0] = along
    np.add(s * x, c * y, out=found[..., 1])
    return found
