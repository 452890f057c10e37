"""The array types of the project: float64, little-endian where it meets the wire, read-only where it is a value."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]


def timeline(first: int, last: int, interval: float) -> FloatArray:
    """Times of ticks first .. last - 1, `interval` apart [s]."""
    return np.arange(first, last, dtype=np.float64) * interval


def frozen(values: ArrayLike) -> FloatArray:
    """A read-only, contiguous float64 copy."""
    array = np.array(values, dtype=np.float64, order="C")
    array.flags.writeable = False
    return array


def read_only(array: FloatArray) -> FloatArray:
    """The same array, which nobody else has yet, made read-only."""
    array.flags.writeable = False
    return array
