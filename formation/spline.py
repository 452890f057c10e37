"""A cubic spline in the plane with continuous curvature, closed or open, and its travel at constant speed."""

from dataclasses import dataclass

import numpy as np

from formation.arrays import FloatArray

SAMPLES_PER_SEGMENT = 16
"""Knots per waypoint segment after reparametrising by arc length; speed then varies by some tenths of a percent on
gentle curves, by some percent at a waypoint with a sharp bend."""


@dataclass(frozen=True, slots=True)
class Spline:
    """Piecewise cubic through knots; linear beyond an open end, periodic if closed."""

    knots: FloatArray
    """(M,) increasing parameter values, the first is 0."""
    points: FloatArray
    """(M, 2) [m]; of a closed curve the last equals the first."""
    slopes: FloatArray
    """(M, 2) derivative at the knots."""
    closed: bool

    @property
    def length(self) -> float:
        """The last parameter value: the length [m] once parametrised by arc length."""
        return float(self.knots[-1])

    @classmethod
    def through(cls, points: FloatArray, *, closed: bool) -> "Spline":
        """The curve through the points, parametrised by chord length (a natural spline if open)."""
        if closed:
            points = np.vstack([points, points[:1]])
        gaps = np.hypot(*np.diff(points, axis=0).T)
        knots = np.concatenate([[0.0], np.cumsum(gaps)])
        return cls(knots, points, _slopes(gaps, points, closed), closed)

    def __call__(self, s: FloatArray) -> FloatArray:
        """Points at parameters s, of shape s.shape + (2,)."""
        inside = np.mod(s, self.length) if self.closed else np.clip(s, 0.0, self.length)
        i = np.clip(np.searchsorted(self.knots, inside, side="right") - 1, 0, len(self.knots) - 2)
        h = (self.knots[i + 1] - self.knots[i])[..., None]
        u = (inside - self.knots[i])[..., None] / h
        points = (
            (1 + 2 * u) * (1 - u) ** 2 * self.points[i]
            + u * (1 - u) ** 2 * h * self.slopes[i]
            + u**2 * (3 - 2 * u) * self.points[i + 1]
            + u**2 * (u - 1) * h * self.slopes[i + 1]
        )
        if self.closed:
            return points
        end = np.where((s < 0.0)[..., None], self.slopes[0], self.slopes[-1])
        return np.asarray(points + (s - inside)[..., None] * end)

    def by_arc_length(self) -> "Spline":
        """The same curve (up to a fine resampling) with arc length [m] as its parameter."""
        fine = np.unique(
            np.concatenate(
                [
                    np.linspace(a, b, SAMPLES_PER_SEGMENT * 16 + 1)
                    for a, b in zip(self.knots, self.knots[1:], strict=False)
                ]
            )
        )
        lengths = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(self(fine), axis=0).T))])
        segments = SAMPLES_PER_SEGMENT * (len(self.knots) - 1)
        parameters = np.interp(np.linspace(0.0, lengths[-1], segments + 1), lengths, fine)
        points = self(parameters[:-1]) if self.closed else self(parameters)
        return Spline.through(points, closed=self.closed)


def _slopes(gaps: FloatArray, points: FloatArray, closed: bool) -> FloatArray:
    """Derivatives (M, 2) at the knots that make the second derivative continuous."""
    m = len(points)
    chords = np.diff(points, axis=0) / gaps[:, None]
    matrix, right = np.zeros((m, m)), np.zeros((m, 2))
    for i in range(1, m - 1):
        matrix[i, i - 1 : i + 2] = gaps[i], 2 * (gaps[i - 1] + gaps[i]), gaps[i - 1]
        right[i] = 3 * (gaps[i] * chords[i - 1] + gaps[i - 1] * chords[i])
    if closed:  # row 0: smooth across the seam; last row: the seam is one point
        matrix[0, 0] = 2 * (gaps[-1] + gaps[0])
        matrix[0, 1], matrix[0, m - 2] = gaps[-1], gaps[0]
        right[0] = 3 * (gaps[0] * chords[-1] + gaps[-1] * chords[0])
        matrix[-1, 0], matrix[-1, -1] = 1.0, -1.0
    else:  # natural ends: no curvature
        matrix[0, :2], right[0] = (2.0, 1.0), 3 * chords[0]
        matrix[-1, -2:], right[-1] = (1.0, 2.0), 3 * chords[-1]
    return np.asarray(np.linalg.solve(matrix, right))
