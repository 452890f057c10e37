"""Statistics over seeds: means with Student's confidence intervals, paired ratios to a baseline, bounds."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import stdtrit

from experiments.study.study import Bound, Study, Value
from experiments.study.table import Row
from experiments.trials.measures import MEASURES
from formation.arrays import FloatArray

CONFIDENCE = 0.95


def student(freedom: int) -> float:
    """The two-sided quantile of Student's t at CONFIDENCE."""
    return float(stdtrit(freedom, (1.0 + CONFIDENCE) / 2.0))


@dataclass(frozen=True, slots=True)
class Interval:
    """A mean over seeds, and where the true one lies with a confidence of 95 % if the deviations are normal."""

    mean: float
    low: float
    high: float


def interval(values: FloatArray) -> Interval | None:
    """Of values (n,); None without any; without width for one."""
    if not values.size:
        return None
    mean = float(values.mean())
    if values.size == 1:
        return Interval(mean, mean, mean)
    half = student(values.size - 1) * float(values.std(ddof=1)) / math.sqrt(values.size)
    return Interval(mean, mean - half, mean + half)


_OVER_SEEDS: dict[str, Callable[[FloatArray], float]] = {
    "mean": np.mean,
    "median": np.median,
    "min": np.min,
    "max": np.max,
    "ratio": np.mean,
}


@dataclass(frozen=True, slots=True, eq=False)
class Group:
    """All trials of one point of the grid, as far as one measure goes."""

    cell: dict[str, Value]
    """Column and label: the scenario and every axis."""
    measure: str
    trials: int
    values: FloatArray
    """What was measured; fewer than trials where some have no value."""
    ratios: FloatArray
    """To the trial of the same seed at the baseline; empty without one."""

    @property
    def missing(self) -> int:
        """Trials without a value, such as those that did not recover."""
        return self.trials - len(self.values)

    def statistic(self, name: str) -> float:
        """mean, median, min, max or ratio; infinite if a trial has no value, NaN if there is none."""
        if self.missing:
            return math.inf
        values = self.ratios if name == "ratio" else self.values
        if not values.size:
            return math.nan
        return float(_OVER_SEEDS[name](values))


def groups(study: Study, table: Sequence[Row]) -> list[Group]:
    """One per point of the grid and measure, in the order of the table."""
    columns = list(study.labels)
    cells: dict[tuple[object, ...], list[Row]] = {}
    for row in table:
        cells.setdefault(tuple(row[name] for name in columns), []).append(row)
    found = []
    for key, same in cells.items():
        base = tuple(study.baseline.get(name, label) for name, label in zip(columns, key, strict=True))
        reference = {row["seed"]: row for row in cells[base]} if study.baseline else {}
        for measure in study.measures:
            values = [float(row[measure]) for row in same if row[measure] is not None]  # type: ignore[arg-type]
            pairs = [(row[measure], reference.get(row["seed"], {}).get(measure)) for row in same]
            ratios = [float(a) / float(b) for a, b in pairs if a is not None and b]
            cell = {name: row_label for name, row_label in same[0].items() if name in columns}
            found.append(Group(cell, measure, len(same), np.array(values), np.array(ratios)))  # type: ignore[arg-type]
    return found


SUMMARY = ("measure", "unit", "trials", "missing", "mean", "low", "high", "median", "max")
NOTHING: Row = {"median": None, "max": None}
RATIOS = ("ratio", "ratio_low", "ratio_high")


def summary(study: Study, found: Sequence[Group]) -> tuple[list[Row], list[str]]:
    """Rows and columns of the table of statistics."""
    table: list[Row] = []
    for group in found:
        over = interval(group.values)
        row: Row = dict(group.cell)
        row |= {"measure": group.measure, "unit": MEASURES[group.measure].unit}
        row |= {"trials": group.trials, "missing": group.missing}
        row |= dict(zip(("mean", "low", "high"), _three(over), strict=True))
        row |= {"median": float(np.median(group.values)), "max": float(group.values.max())} if over else NOTHING
        row |= dict(zip(RATIOS, _three(interval(group.ratios)), strict=True))
        table.append(row)
    return table, [*study.labels, *SUMMARY, *(RATIOS if study.baseline else ())]


def _three(over: Interval | None) -> tuple[float | None, float | None, float | None]:
    return (None, None, None) if over is None else (over.mean, over.low, over.high)


@dataclass(frozen=True, slots=True)
class BoundCheck:
    """A bound, and what was found."""

    bound: Bound
    cell: dict[str, Value]
    """Where it was worst."""
    found: float
    """Infinite if a trial had no value."""

    @property
    def holds(self) -> bool:
        return math.isfinite(self.found) and self.bound.excess(self.found) <= 0.0


def _excess(check: BoundCheck) -> float:
    return check.bound.excess(check.found) if math.isfinite(check.found) else math.inf


def check_bounds(study: Study, found: Sequence[Group]) -> list[BoundCheck]:
    """Every bound of the study at the point of the grid where it is worst."""
    checks = []
    for bound in study.bounds:
        here = [
            BoundCheck(bound, group.cell, group.statistic(bound.statistic))
            for group in found
            if group.measure == bound.measure and all(group.cell[k] == v for k, v in bound.where.items())
        ]
        checks.append(max(here, key=_excess))
    return checks
