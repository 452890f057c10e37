"""Points made smooth: the least bent curve that passes every point within a largest deviation.

It is the smoothing spline of Reinsch (Numer. Math. 10, 1967), which minimises the sum of squared deviations plus a
factor times the integral of the squared second derivative; the factor is the largest that keeps the deviation.
"""

import numpy as np

from formation.arrays import FloatArray
from formation.paths.banded import pentadiagonal

CLOSE = 0.02
"""The largest deviation is met within this share."""
RANGE = 12.0
"""Powers of ten below the length cubed in which the factor is sought, beside those of the mean gap."""
FINE = 0.01
"""Powers of ten that need not be told apart."""
TINY = 1e-9
"""A deviation below this share of the largest counts as this, so that it has a logarithm."""


def smoothed(points: FloatArray, deviation: float, *, closed: bool) -> FloatArray:
    """Points (M, 2) of the least bent curve that passes each of the points (M, 2) within `deviation` [m].

    Of a closed curve the first point is not given again at the end.
    """
    count = len(points)
    if count < 3 or deviation <= 0.0:
        return points
    if not closed:
        return _within(points, slice(0, count), deviation)
    # Half a lap more on both sides: what an end does to the lap in the middle fades with the distance.
    more = count // 2 + 1
    laps = np.concatenate([points[-more:], points, points[:more]])
    return _within(laps, slice(more, more + count), deviation)


def _within(points: FloatArray, kept: slice, deviation: float) -> FloatArray:
    """The smoothest of the `kept` points that keep the deviation."""
    gaps = np.hypot(*np.diff(points, axis=0).T)
    unit = float(gaps.sum()) ** 3
    powers, logs = [-RANGE - 3.0 * np.log10(len(gaps)), 3.0], [-np.inf, np.inf]
    best, aim = points[kept], np.log((1.0 - CLOSE / 2.0) * deviation)
    while powers[1] - powers[0] > FINE:
        power = _between(powers, logs, aim)
        found = _smooth(points, gaps, unit * 10.0**power)[kept]
        off = float(np.hypot(*(found - points[kept]).T).max())
        side = int(off > deviation)
        powers[side], logs[side] = power, np.log(max(off, TINY * deviation))
        if side == 0:
            best = found
            if off > (1.0 - CLOSE) * deviation:
                break
    return best


def _between(powers: list[float], logs: list[float], aim: float) -> float:
    """The next power to try: where the straight line between two known deviations meets the aim, or the middle."""
    share = (aim - logs[0]) / (logs[1] - logs[0]) if np.isfinite(logs).all() else 0.5
    return powers[0] + min(max(share, 0.1), 0.9) * (powers[1] - powers[0])


def _smooth(points: FloatArray, gaps: FloatArray, factor: float) -> FloatArray:
    """The smoothing spline's points (M, 2), with as much weight on bending as `factor` gives [m^3]."""
    inverse = 1.0 / gaps
    before, after = inverse[:-1], inverse[1:]
    here = -(before + after)
    # Q (M, M - 2) has the columns (before, here, after): second differences. R and Q^T Q have these diagonals.
    squares = before**2 + here**2 + after**2
    beside = here[:-1] * before[1:] + after[:-1] * here[1:]
    bends = np.diff(np.diff(points, axis=0) * inverse[:, None], axis=0)
    second = pentadiagonal(
        (gaps[:-1] + gaps[1:]) / 3.0 + factor * squares,
        gaps[1:-1] / 6.0 + factor * beside,
        factor * after[:-2] * before[2:],
        bends,
    )
    correction = np.zeros_like(points)
    correction[:-2] += before[:, None] * second
    correction[1:-1] += here[:, None] * second
    correction[2:] += after[:, None] * second
    return np.asarray(points - factor * correction)
