"""What this project claims over the paper for two robots on the four paths, beside what was found."""

from collections.abc import Mapping

import numpy as np

from experiments.metrics import spread
from experiments.report.report import Verdict, grade
from experiments.report.table import Cell, Table
from experiments.trials.result import Signals

MEDIAN = 0.04
"""Largest median of |l_e| on any path [mm]."""
MAXIMUM = {"spiral": 1.5}
"""Largest |l_e| from t = 0 on [mm], where it is not `MAXIMUM_ELSEWHERE`."""
MAXIMUM_ELSEWHERE = 0.5
NEAR = 1.5
"""`nash` is within this factor of the centralised optimum's RMS ..."""
NEAR_ABOVE = 0.05
"""... where that is above this [mm]."""


def bounds(paths: Mapping[str, Mapping[str, Signals]]) -> tuple[Table, Verdict]:
    """The table of `nash` against its bounds by path, and the verdict of it."""
    rows: list[tuple[Cell, ...]] = []
    parts: list[bool] = []
    for path, trials in paths.items():
        found = spread(np.abs(trials["nash"].distance) * 1e3)
        limit = MAXIMUM.get(path, MAXIMUM_ELSEWHERE)
        parts += [found.median <= MEDIAN, found.maximum <= limit]
        best = None
        if "centralised" in trials:
            best = spread(trials["centralised"].distance * 1e3).rms
            if best > NEAR_ABOVE:
                parts.append(found.rms <= NEAR * best)
        ratio = None if best is None or best <= NEAR_ABOVE else found.rms / best
        rows.append((path, found.median, MEDIAN, found.maximum, limit, found.rms, best, ratio))
    heads = ("path", "median mm", "bound mm", "maximum mm", "bound mm", "RMS mm", "centralised RMS mm", "ratio")
    table = Table("bounds", "nash against its bounds: |lₑ|, two robots, from t = 0 on", heads, tuple(rows))
    verdict = Verdict(
        f"This project: the median of |lₑ| of `nash` is at most {MEDIAN} mm on every path, its maximum at most "
        f"{MAXIMUM_ELSEWHERE} mm on paths 1 to 3 and {MAXIMUM['spiral']} mm on the spiral, and its RMS within {NEAR} "
        f"times the centralised optimum's where that is above {NEAR_ABOVE} mm.",
        f"{sum(parts)} of {len(parts)} bounds are kept; the table below has them all.",
        grade(parts),
    )
    return table, verdict
