"""Shapes by name: where the robots of a formation stand in the body frame."""

import math

import numpy as np

from formation.arrays import FloatArray
from formation.pattern import rotate


def line(robots: int, spacing: float) -> FloatArray:
    """Side by side across the path, robot 1 rightmost (the paper's "in-line" formation of two)."""
    y = spacing * (np.arange(robots) - (robots - 1) / 2.0)
    return np.stack([np.zeros(robots), y], axis=1)


def column(robots: int, spacing: float) -> FloatArray:
    """One behind the other along the path, robot 1 first."""
    x = -spacing * (np.arange(robots) - (robots - 1) / 2.0)
    return np.stack([x, np.zeros(robots)], axis=1)


def polygon(robots: int, spacing: float) -> FloatArray:
    """Corners of a regular polygon with side `spacing`, counter-clockwise, robot 1 in front."""
    around = 2.0 * math.pi * np.arange(robots) / robots
    radius = spacing / (2.0 * math.sin(math.pi / robots))
    return radius * np.stack([np.cos(around), np.sin(around)], axis=1)


def square(robots: int, spacing: float) -> FloatArray:
    """A square whose sides are along and across the path, robot 1 front left."""
    return rotate(np.array(math.pi / 4.0), polygon(robots, spacing))


def wedge(robots: int, spacing: float) -> FloatArray:
    """A V with its tip in front and a right angle between its arms, robot 1 at the right end.

    An even number has two robots side by side in front.
    """
    arm = np.arange(robots) - (robots - 1) / 2.0
    front = np.abs(arm).min()
    back = math.sqrt(0.5) * (np.abs(arm) - front)
    offsets = spacing * np.stack([-back, np.sign(arm) * (back + front)], axis=1)
    return np.asarray(offsets - offsets.mean(axis=0))


SHAPES = {
    "line": line,
    "column": column,
    "triangle": polygon,
    "square": square,
    "polygon": polygon,
    "wedge": wedge,
}
"""Shape by name: a function of (robots, spacing) that returns offsets (n, 2) [m] with mean zero."""

FIXED_SIZES = {"triangle": 3, "square": 4}
"""Shapes whose name says how many robots they have."""
