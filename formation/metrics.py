"""Errors of a formation: pattern errors, tracking error, the paper's error state; RMS and quantiles of any signal."""

import math
from collections.abc import Collection
from typing import overload

import numpy as np

from formation.arrays import FloatArray, IntArray
from formation.pattern import rotate
from formation.unicycle import wrap

CROWD = 64
"""Of so many robots all pairs are looked at."""
SLACK = 1.0 + 1e-9
"""Of a radius, so that rounding hides nobody."""
PAIRS_AT_ONCE = 1_000_000
"""Distances between robots that `clearance` holds in memory at a time."""


@overload
def rms(values: FloatArray) -> float: ...
@overload
def rms(values: FloatArray, axis: int) -> FloatArray: ...
def rms(values: FloatArray, axis: int | None = None) -> float | FloatArray:
    """Root of the mean square: a float of all values, or an array along one axis."""
    found: FloatArray = np.sqrt(np.mean(np.square(values), axis=axis))
    return float(found) if axis is None else found


def quantile(values: FloatArray, share: float) -> float | None:
    """The quantile at a share from 0 to 1 of the finite values; None if there are none."""
    finite = values[np.isfinite(values)]
    return float(np.quantile(finite, share)) if finite.size else None


def quantiles(values: FloatArray, *shares: float) -> list[float] | list[None]:
    """`quantile` at several shares; one after the other takes as many times as long."""
    finite = values[np.isfinite(values)]
    return np.quantile(finite, shares).tolist() if finite.size else [None] * len(shares)


def wrapped(angles: FloatArray) -> FloatArray:
    """The same angles in (-pi, pi] [rad]."""
    return np.arctan2(np.sin(angles), np.cos(angles))


def pairs(places: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Pattern q = (l, psi) of every robot and its upstream neighbour (section 2.1).

    Args:
        places: (..., n, 2 or more) where the robots, or their slots, are.

    Returns:
        l = |p_i - p_-i| [m] and psi = atan2(x_i - x_-i, y_-i - y_i) [rad], each (..., n).
    """
    gap = places[..., :2] - np.roll(places[..., :2], 1, axis=-2)
    return np.hypot(gap[..., 0], gap[..., 1]), np.arctan2(gap[..., 0], -gap[..., 1])


def pattern_errors(poses: FloatArray, slots: FloatArray, away: Collection[int] = ()) -> tuple[FloatArray, FloatArray]:
    """Distance and angle errors of every pair: l_e = l_r - l [m] and psi_e = psi_r - psi [rad] (section 2.1).

    Args:
        poses: (..., n, 2 or more) poses of all robots.
        slots: (..., n, 2 or more) where they should be; only their relative positions count.
        away: numbers of robots over which the ring is closed; they have no error.

    Returns:
        l_e and psi_e, each (..., n).
    """
    if away:
        rows = [row for row in range(poses.shape[-2]) if row + 1 not in away]
        of_all = np.zeros(np.broadcast_shapes(poses.shape[:-1], slots.shape[:-1]))
        angles = of_all.copy()
        of_all[..., rows], angles[..., rows] = pattern_errors(poses[..., rows, :], slots[..., rows, :])
        return of_all, angles
    distance, angle = pairs(poses)
    wanted, wanted_angle = pairs(slots)
    return wanted - distance, wrapped(wanted_angle - angle)


def clearance(places: FloatArray) -> float:
    """The least distance between any two robots at any time [m].

    Args:
        places: (T, n, 2 or more) of all robots, at least two.
    """
    one, other = np.triu_indices(places.shape[1], k=1)
    rows = max(1, PAIRS_AT_ONCE // len(one))
    least = np.inf
    for first in range(0, len(places), rows):
        gap = places[first : first + rows, one, :2] - places[first : first + rows, other, :2]
        least = min(least, float(np.hypot(gap[..., 0], gap[..., 1]).min()))
    return least


def near(places: FloatArray, radius: float) -> tuple[IntArray, IntArray]:
    """Pairs that may be within a radius of each other, and few others; all pairs of 1024 robots are half a million.

    Robots are sorted along the longer side of their extent; partners are sought within the radius along it.

    Args:
        places: (n, 2 or more) [m].
        radius: [m].

    Returns:
        Rows (m,) and (m,), the lower one first.
    """
    along = places[:, int(np.ptp(places[:, 1]) > np.ptp(places[:, 0]))]
    order = np.argsort(along, kind="stable")
    line = along[order]
    after = np.arange(len(line)) + 1
    ends = np.maximum(np.searchsorted(line, line + SLACK * radius, side="right"), after)
    counts = ends - after
    one = np.repeat(after - 1, counts)
    other = np.arange(len(one)) - np.repeat(np.cumsum(counts) - counts, counts) + one + 1
    one, other = order[one], order[other]
    return np.minimum(one, other), np.maximum(one, other)


def nearest(places: FloatArray) -> tuple[int, int, float]:
    """The two robots that are nearest to each other: their numbers, and how far apart they are [m].

    Args:
        places: (n, 2 or more) of all robots, at least two.
    """
    if len(places) > CROWD:
        one, other = near(places, float(pairs(places)[0].min()))
        order = np.lexsort((other, one))
        one, other = one[order], other[order]
    else:
        one, other = np.triu_indices(len(places), k=1)
    apart = np.hypot(*(places[one, :2] - places[other, :2]).T)
    at = int(apart.argmin())
    return int(one[at]) + 1, int(other[at]) + 1, float(apart[at])


def tracking_error_of_some(poses: FloatArray, slots: FloatArray, away: Collection[int]) -> FloatArray:
    """Distance (...) of the mean position of the robots that are not away to that of their slots [m]."""
    rows = [row for row in range(poses.shape[-2]) if row + 1 not in away]
    return tracking_error(poses[..., rows, :], slots[..., rows, :2].mean(axis=-2))


def tracking_error(poses: FloatArray, centre: FloatArray) -> FloatArray:
    """Distance (...) of the robots' mean position to the reference point (..., 2) [m]."""
    gap: FloatArray = poses[..., :2].mean(axis=-2) - centre
    return np.hypot(gap[..., 0], gap[..., 1])


def error_state(
    own: FloatArray,
    other: FloatArray,
    reference: FloatArray,
    distance: float,
    psi_r: float,
    virtual_centre: FloatArray,
) -> FloatArray:
    """The paper's error state z = (x_e, y_e, theta_e, l_e, psi_e) of one pair (section 2.1).

    Args:
        own, other: poses (3,) of robot i and of its upstream neighbour -i.
        reference: (3,) x_r, y_r, theta_r of the formation's centre.
        distance: l_r [m].
        psi_r: psi_r at this time [rad].
        virtual_centre: p_v^O (2,) [m].
    """
    pair = (own[:2] + other[:2]) / 2.0
    theta_c = (own[2] + other[2]) / 2.0
    psi = math.atan2(own[0] - other[0], other[1] - own[1])
    gap = reference[:2] - (pair + rotate(np.array(psi), virtual_centre))
    x_e, y_e = rotate(np.array(-theta_c), gap)
    length = math.hypot(own[0] - other[0], own[1] - other[1])
    return np.array([x_e, y_e, wrap(reference[2] - theta_c), distance - length, wrap(psi_r - psi)])
