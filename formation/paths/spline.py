"""A cubic spline in the plane with continuous curvature, closed or open, and its travel at constant speed."""

from dataclasses import dataclass

import numpy as np

from formation.arrays import FloatArray
from formation.paths.banded import cyclic_tridiagonal, tridiagonal

PIECES = 64
"""Pieces per segment between two waypoints, on which arc length is integrated and inverted; fewer if there are many."""
ALL_PIECES = 65536
"""Pieces of a curve through many points; its segments are short, and a quarter of them is straight enough."""
LEAST_PIECES = 4
GAUSS_NODES, GAUSS_WEIGHTS = np.polynomial.legendre.leggauss(4)
TINY = 1e-30
"""A bend below this is none."""
STEEP = 3.0
"""A cubic whose slopes are within so many times its mean slope has no turning point (Fritsch and Carlson)."""
LEAST_SPEED = 1e-9
"""Where a curve stands still (a cusp), so that its inverse stays finite."""


@dataclass(frozen=True, slots=True)
class Spline:
    """Piecewise cubic through knots; straight on beyond an open end, periodic if closed."""

    knots: FloatArray
    """(M,) increasing parameter values, the first is 0."""
    points: FloatArray
    """(M, 2) [m]; of a closed curve the last equals the first."""
    slopes: FloatArray
    """(M, 2) derivative at the knots."""
    closed: bool

    @property
    def length(self) -> float:
        """The last parameter value."""
        return float(self.knots[-1])

    @property
    def pieces(self) -> int:
        """Pieces per segment on which arc length is integrated."""
        return min(max(ALL_PIECES // (len(self.knots) - 1), LEAST_PIECES), PIECES)

    @classmethod
    def through(cls, points: FloatArray, *, closed: bool) -> "Spline":
        """The curve through the points, parametrised by chord length (a natural spline if open)."""
        if closed:
            points = np.vstack([points, points[:1]])
        gaps = np.hypot(*np.diff(points, axis=0).T)
        knots = np.concatenate([[0.0], np.cumsum(gaps)])
        return cls(knots, points, _slopes(gaps, points, closed), closed)

    def __call__(self, p: FloatArray) -> FloatArray:
        """Points at parameters p, of shape p.shape + (2,) [m]."""
        inside = np.mod(p, self.length) if self.closed else np.clip(p, 0.0, self.length)
        points, _ = _hermite(inside, self.knots, self.points, self.slopes)
        if self.closed:
            return points
        end = np.where((p < 0.0)[..., None], self.slopes[0], self.slopes[-1])
        return np.asarray(points + (p - inside)[..., None] * end)

    def speed(self, p: FloatArray) -> FloatArray:
        """|dr/dp| at parameters p between the ends."""
        _, derivative = _hermite(p, self.knots, self.points, self.slopes)
        return np.hypot(derivative[..., 0], derivative[..., 1])

    @property
    def radii(self) -> FloatArray:
        """(M,) radius of curvature at the knots [m]."""
        h = np.diff(self.knots)[:, None]
        gaps, slopes = np.diff(self.points, axis=0), self.slopes
        bend = (6.0 * gaps - h * (4.0 * slopes[:-1] + 2.0 * slopes[1:])) / h**2
        last = (-6.0 * gaps[-1:] + h[-1:] * (2.0 * slopes[-2:-1] + 4.0 * slopes[-1:])) / h[-1:] ** 2
        bend = np.vstack([bend, last])
        across = np.abs(slopes[:, 0] * bend[:, 1] - slopes[:, 1] * bend[:, 0])
        return np.asarray(np.hypot(slopes[:, 0], slopes[:, 1]) ** 3 / np.maximum(across, TINY))

    def by_arc_length(self) -> "Travel":
        """The same curve with arc length as its parameter."""
        pieces = self.pieces
        fine = np.linspace(self.knots[:-1], self.knots[1:], pieces, endpoint=False, axis=1)
        fine = np.concatenate([fine.ravel(), self.knots[-1:]])
        half = np.diff(fine) / 2.0
        nodes = (fine[:-1] + half)[:, None] + half[:, None] * GAUSS_NODES
        lengths = np.concatenate([[0.0], np.cumsum((self.speed(nodes) * GAUSS_WEIGHTS).sum(axis=1) * half)])
        # Where the curve nearly stands still its inverse is steep: no steeper than lets it rise everywhere.
        mean = np.diff(fine) / np.maximum(np.diff(lengths), TINY)
        steepest = STEEP * np.minimum(np.append(mean, mean[-1]), np.insert(mean, 0, mean[0]))
        return Travel(self, lengths, fine, np.minimum(1.0 / np.maximum(self.speed(fine), LEAST_SPEED), steepest))


@dataclass(frozen=True, slots=True)
class Travel:
    """A spline travelled at unit speed."""

    curve: Spline
    lengths: FloatArray
    """(K,) arc lengths from the first point [m]."""
    parameters: FloatArray
    """(K,) the curve's parameters there."""
    rates: FloatArray
    """(K,) their derivative by arc length."""

    @property
    def length(self) -> float:
        """The whole way [m]."""
        return float(self.lengths[-1])

    @property
    def at_knots(self) -> FloatArray:
        """(M,) arc lengths at the curve's knots [m]."""
        return self.lengths[:: self.curve.pieces]

    def __call__(self, s: FloatArray) -> FloatArray:
        """Points at arc lengths s [m], of shape s.shape + (2,) [m]; straight on past an open end."""
        inside = np.mod(s, self.length) if self.curve.closed else np.clip(s, 0.0, self.length)
        p, _ = _hermite(inside, self.lengths, self.parameters[:, None], self.rates[:, None])
        beyond = (s - inside) * np.where(s < 0.0, self.rates[0], self.rates[-1])
        return self.curve(p[..., 0] + (0.0 if self.curve.closed else beyond))


def _hermite(x: FloatArray, knots: FloatArray, values: FloatArray, slopes: FloatArray) -> tuple[FloatArray, FloatArray]:
    """The cubic with these values (M, D) and slopes (M, D) at the knots (M,), and its derivative; x.shape + (D,)."""
    i = np.clip(np.searchsorted(knots, x, side="right") - 1, 0, len(knots) - 2)
    h = (knots[i + 1] - knots[i])[..., None]
    u = (x - knots[i])[..., None] / h
    a, b, da, db = values[i], values[i + 1], h * slopes[i], h * slopes[i + 1]
    value = (1 + 2 * u) * (1 - u) ** 2 * a + u * (1 - u) ** 2 * da + u**2 * (3 - 2 * u) * b + u**2 * (u - 1) * db
    derivative = (6 * u * (u - 1) * (a - b) + (1 - u) * (1 - 3 * u) * da + u * (3 * u - 2) * db) / h
    return value, derivative


def _slopes(gaps: FloatArray, points: FloatArray, closed: bool) -> FloatArray:
    """Derivatives (M, 2) at the knots that make the second derivative continuous."""
    chords = np.diff(points, axis=0) / gaps[:, None]
    if closed:
        before, around = np.roll(gaps, 1), np.roll(chords, 1, axis=0)
        right = 3.0 * (gaps[:, None] * around + before[:, None] * chords)
        found = cyclic_tridiagonal(gaps, 2.0 * (before + gaps), before, right)
        return np.vstack([found, found[:1]])
    ends = np.ones(1)
    inner = 3.0 * (gaps[1:, None] * chords[:-1] + gaps[:-1, None] * chords[1:])
    # Natural ends: no curvature.
    lower, upper = np.concatenate([ends, gaps[1:], ends]), np.concatenate([ends, gaps[:-1], ends])
    diagonal = np.concatenate([2.0 * ends, 2.0 * (gaps[:-1] + gaps[1:]), 2.0 * ends])
    return tridiagonal(lower, diagonal, upper, np.vstack([3.0 * chords[:1], inner, 3.0 * chords[-1:]]))
