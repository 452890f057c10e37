"""Measures of error signals: what a box-and-whisker plot shows, and what tables say."""

from dataclasses import dataclass

import numpy as np

from formation.arrays import FloatArray


@dataclass(frozen=True, slots=True)
class Spread:
    """Five numbers of a box plot whose whiskers are the range (figs. 6-7 of the paper), and the RMS."""

    minimum: float
    lower: float
    """Lower quartile."""
    median: float
    upper: float
    """Upper quartile."""
    maximum: float
    rms: float

    @property
    def width(self) -> float:
        """Interquartile range: the height of the box."""
        return self.upper - self.lower


def spread(values: FloatArray) -> Spread:
    """The spread of all values, of whatever shape and unit."""
    minimum, lower, median, upper, maximum = np.quantile(values, (0.0, 0.25, 0.5, 0.75, 1.0)).tolist()
    return Spread(minimum, lower, median, upper, maximum, rms(values))


def rms(values: FloatArray) -> float:
    """Root of the mean square of all values."""
    return float(np.sqrt(np.mean(np.square(values))))


def settled(times: FloatArray, size: FloatArray, bound: float, since: float) -> float | None:
    """Seconds from `since` until `size` stays at or below `bound` to the end; None if it does not.

    Args:
        times: (T,) [s].
        size: (T,) not negative.
        bound: in the unit of `size`.
        since: a time in `times` [s].
    """
    above = np.flatnonzero(size > bound)
    if above.size == 0:
        return 0.0
    last = int(above[-1])
    return None if last == len(times) - 1 else max(0.0, float(times[last + 1]) - since)
