"""A study from start to end: simulate what is missing, then write its table, statistics and figures into a folder."""

import json
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from experiments.study import grid
from experiments.study.intervals import BoundCheck, check_bounds, groups, summary
from experiments.study.study import Study
from experiments.study.table import Row, rows, types, write_csv, write_parquet
from experiments.trials.batch import Place, run_batch
from experiments.trials.code_version import code_version
from experiments.trials.pool import Progress
from experiments.trials.result import TrialResult, result_of
from experiments.trials.trial import SERIES_INTERVAL, Trial


@dataclass(frozen=True, slots=True, eq=False)
class Outcome:
    """What a study has found."""

    study: Study
    statistics: list[Row]
    """Of every measure at every point of the grid (`summary.csv`)."""
    checks: list[BoundCheck]
    files: list[Path]

    def plain(self) -> dict[str, Any]:
        """As JSON has it; what was not found, such as a recovery that never came, is null."""
        return {
            "study": self.study.name,
            "trials": self.study.trials,
            "seeds": self.study.seeds,
            "statistics": self.statistics,
            "bounds": [
                {
                    **check.bound.model_dump(),
                    "where": check.cell,
                    "found": check.found if math.isfinite(check.found) else None,
                    "holds": check.holds,
                }
                for check in self.checks
            ],
            "files": [str(file) for file in self.files],
        }


def run_and_write(study: Study, place: Place, *, tell: Callable[[str], None], progress: Progress) -> Outcome:
    """Simulate what the folder's journal lacks, and write everything there.

    Args:
        study: what is simulated.
        place: where, and into which folder.
        tell: called with lines for the user.
        progress: called for each trial whose result is there.

    Raises:
        EchelonError: the study cannot be simulated, or a trial failed.
    """
    trials = grid.trials(study)
    found = run_batch(trials, place, tell=tell, progress=progress)
    return write(
        study, trials, [result_of(trial, plain) for trial, plain in zip(trials, found, strict=True)], place.folder
    )


def write(study: Study, trials: Sequence[Trial], results: Sequence[TrialResult], folder: Path) -> Outcome:
    """Write `trials` and `summary` (CSV, Parquet), `series.parquet`, `study.json` and the figures."""
    from experiments.study.figures import draw  # noqa: PLC0415  matplotlib, after the trials

    table = rows(study, trials, results)
    found = groups(study, table)
    statistics, columns = summary(study, found)
    csv = write_csv(folder / "trials.csv", table, list(types(study)))
    files = [csv, write_parquet(csv, types(study)), write_csv(folder / "summary.csv", statistics, columns)]
    if study.keeps_series:
        series = write_csv(folder / "series.csv", _series(study, results), list(SERIES))
        files.append(write_parquet(series, SERIES))
        series.unlink()  # long, and of use to programs only
    about = folder / "study.json"
    text = json.dumps({"study": study.model_dump(exclude_defaults=True), "code": code_version()}, indent=1)
    about.write_text(text + "\n", encoding="utf-8")
    files += [about, *draw(study, trials, results, table, folder)]
    return Outcome(study, statistics, check_bounds(study, found), files)


SERIES = {"trial": "BIGINT", "t": "DOUBLE", "level_m": "DOUBLE"}


def _series(study: Study, results: Sequence[TrialResult]) -> list[Row]:
    return [
        {"trial": index, "t": study.warmup + SERIES_INTERVAL * k, "level_m": level}
        for index, result in enumerate(results)
        for k, level in enumerate(result.series.tolist())
    ]
