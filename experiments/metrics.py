"""Metrics of error signals in reports and studies; `rms`, `quantile` and `clearance` are in formation/metrics.py."""

from dataclasses import dataclass

import numpy as np

from formation.arrays import FloatArray
from formation.metrics import rms


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


def trailing_rms(values: FloatArray, window: int) -> FloatArray:
    """RMS over the last `window` samples of values (T, n), fewer at the beginning: (T, n)."""
    if window <= 1:
        return np.abs(values)
    total = np.cumsum(np.vstack([np.zeros_like(values[:1]), values**2]), axis=0)
    end = np.arange(1, len(values) + 1)
    begin = np.maximum(0, end - window)
    mean = (total[end] - total[begin]) / (end - begin)[:, None]
    return np.sqrt(np.maximum(mean, 0.0))  # a difference of sums may round below zero


def recovery(
    times: FloatArray, level: FloatArray, *, below: float, since: float, hold: float | None = None
) -> float | None:
    """Seconds from `since` until the level is below a threshold and stays there; None if it never does.

    Args:
        times: (T,) [s].
        level: (T,) not negative.
        below: the threshold, in the unit of `level`.
        since: when the time to recover begins [s].
        hold: how long the level has to stay there [s]; to the end, if None.
    """
    after = times >= since - 1e-9
    good, times = level[after] < below, times[after]
    bad = np.flatnonzero(~good)
    starts = np.concatenate([[0], bad + 1])  # of the stretches without a bad sample between two bad ones
    ends = np.concatenate([bad, [len(good)]])
    for start, end in zip(starts, ends, strict=True):
        last = end == len(good)
        if start < end and (last or (hold is not None and times[end] - times[start] >= hold)):
            return float(times[start] - since)
    return None
