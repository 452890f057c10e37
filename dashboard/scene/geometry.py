"""Shapes and curves as arrays: meshes of bodies, digits as strokes, dashes."""

import math

import numpy as np

from formation.arrays import FloatArray

Faces = np.ndarray[tuple[int, ...], np.dtype[np.uint32]]


def segments(lines: FloatArray, z: float) -> FloatArray:
    """Line segments (n (T - 1), 2, 3) of polylines (n, T, 2)."""
    pairs = np.stack([lines[:, :-1], lines[:, 1:]], axis=2).reshape(-1, 2, 2)
    return lifted(pairs, z)


def lifted(points: FloatArray, z: float) -> FloatArray:
    """Points (..., 2) as (..., 3) at height z [m]."""
    found = np.empty((*points.shape[:-1], 3))
    found[..., :2], found[..., 2] = points, z
    return found


def dashed(line: FloatArray, dash: float) -> FloatArray:
    """Dashes (M, 2, 2) of about equal length along a polyline (T, 2) [m]."""
    lengths = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(line, axis=0).T))])
    count = int(np.clip(lengths[-1] / (2.0 * dash), 1, 2000))
    starts = np.arange(count) * lengths[-1] / count
    ends = starts + 0.5 * lengths[-1] / count
    at = np.stack([starts, ends], axis=1)
    return np.stack([np.interp(at, lengths, line[:, 0]), np.interp(at, lengths, line[:, 1])], axis=-1)


def turns(angles: FloatArray) -> FloatArray:
    """Quaternions (n, 4), w first, of turns about z [rad]."""
    zero = np.zeros_like(angles)
    return np.stack([np.cos(angles / 2.0), zero, zero, np.sin(angles / 2.0)], axis=-1)


def teardrop(length: float, width: float, corners: int, grown: float = 0.0) -> tuple[FloatArray, Faces]:
    """A flat body that points along x: a round back and a pointed front; its circle's centre is the origin [m]."""
    return _fan(_rim(length, width, corners, grown))


def teardrop_rim(length: float, width: float, corners: int, thickness: float) -> tuple[FloatArray, Faces]:
    """The outline of a teardrop [m]."""
    return _band(_rim(length, width, corners, -thickness), _rim(length, width, corners, 0.0))


def _rim(length: float, width: float, corners: int, grown: float) -> FloatArray:
    """Points around a teardrop, its tip first; `corners` would go all around a circle."""
    radius, tip = width / 2.0 + grown, length - width / 2.0 + 1.6 * grown
    touch = math.acos(min(1.0, radius / tip))
    around = np.linspace(touch, 2.0 * math.pi - touch, round(0.725 * corners))
    return np.concatenate([[[tip, 0.0]], radius * np.stack([np.cos(around), np.sin(around)], axis=1)])


def arrow_head(length: float, width: float) -> tuple[FloatArray, Faces]:
    """A flat arrow head with its tip in the origin, pointing along x [m]."""
    points = np.array([[-0.72 * length, 0.0], [-length, width / 2.0], [0.0, 0.0], [-length, -width / 2.0]])
    return lifted(points, 0.0), np.array([[0, 2, 1], [0, 3, 2]], dtype=np.uint32)


def ring(radius: float, thickness: float, corners: int) -> tuple[FloatArray, Faces]:
    """A flat ring [m]."""
    around = 2.0 * math.pi * np.arange(corners) / corners
    unit = np.stack([np.cos(around), np.sin(around)], axis=1)
    return _band(unit * (radius - thickness / 2.0), unit * (radius + thickness / 2.0))


def _band(inner: FloatArray, outer: FloatArray) -> tuple[FloatArray, Faces]:
    """The area between two closed polylines (count, 2) each."""
    count = len(inner)
    i = np.arange(count)
    j = (i + 1) % count
    faces = np.concatenate([np.stack([i, i + count, j + count], axis=1), np.stack([i, j + count, j], axis=1)])
    return lifted(np.concatenate([inner, outer]), 0.0), faces.astype(np.uint32)


def _fan(rim: FloatArray) -> tuple[FloatArray, Faces]:
    count = len(rim)
    points = np.concatenate([[[0.0, 0.0]], rim])
    i = np.arange(count)
    faces = np.stack([np.zeros(count, dtype=int), 1 + i, 1 + (i + 1) % count], axis=1)
    return lifted(points, 0.0), faces.astype(np.uint32)


_STROKES = {
    "0": ["00 20 24 04 00"],
    "1": ["03 14 10"],
    "2": ["04 24 22 02 00 20"],
    "3": ["04 24 20 00", "02 22"],
    "4": ["04 02 22", "24 20"],
    "5": ["24 04 02 22 20 00"],
    "6": ["24 04 00 20 22 02"],
    "7": ["04 24 10"],
    "8": ["00 20 24 04 00", "02 22"],
    "9": ["22 02 04 24 20 00"],
}
"""Digits as polylines on a grid of 3 x 5 points, "xy" each, the origin at the bottom left."""


def digits(number: int, height: float) -> FloatArray:
    """Strokes (M, 2, 2) of a number, centred on the origin [m]."""
    text = str(number)
    strokes = []
    for place, digit in enumerate(text):
        for line in _STROKES[digit]:
            points = np.array([[float(point[0]), float(point[1])] for point in line.split()])
            points[:, 0] += 3.2 * place
            strokes.append(np.stack([points[:-1], points[1:]], axis=1))
    joined = np.concatenate(strokes)
    low, high = joined.min(axis=(0, 1)), joined.max(axis=(0, 1))
    shrink = 1.0 if len(text) == 1 else 0.8
    scale = np.array([0.9, 1.0]) * height / 4.0 * shrink
    return np.asarray((joined - (low + high) / 2.0) * scale)
