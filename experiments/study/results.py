"""A study from start to end: fly what is missing, then write its table, statistics and figures into a folder."""

import json
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from experiments.study import grid, runner
from experiments.study.flights import SERIES_INTERVAL, Result
from experiments.study.grid import Job
from experiments.study.intervals import Verdict, groups, summary, verdicts
from experiments.study.journal import Journal
from experiments.study.study import Study
from experiments.study.table import Row, rows, types, write_csv, write_parquet
from runtime.precompile import ensure_compiled


@dataclass(frozen=True, slots=True, eq=False)
class Outcome:
    """What a study has found."""

    study: Study
    statistics: list[Row]
    """Of every measure at every point of the grid (`summary.csv`)."""
    verdicts: list[Verdict]
    files: list[Path]

    def plain(self) -> dict[str, Any]:
        """As JSON has it; what was not found, such as a recovery that never came, is null."""
        return {
            "study": self.study.name,
            "flights": self.study.flights,
            "seeds": self.study.seeds,
            "statistics": self.statistics,
            "bounds": [
                {
                    **verdict.bound.model_dump(),
                    "where": verdict.cell,
                    "found": verdict.found if math.isfinite(verdict.found) else None,
                    "holds": verdict.holds,
                }
                for verdict in self.verdicts
            ],
            "files": [str(file) for file in self.files],
        }


def run_and_write(
    study: Study,
    folder: Path,
    *,
    workers: int,
    cluster: str | None,
    tell: Callable[[str], None],
    progress: Callable[[float, int, int, bool], None],
) -> Outcome:
    """Fly what the folder's journal lacks, and write everything there.

    Args:
        study: what is flown.
        folder: made if it is not there.
        workers: processes of this machine, unless there is a cluster.
        cluster: address of the scheduler of a Dask cluster.
        tell: told lines for people.
        progress: called with the share of the work done, flights done, all flights, and whether one was just flown.

    Raises:
        EchelonError: the study cannot be flown, or a flight failed.
    """
    jobs = grid.jobs(study)
    engine = runner.local(workers) if cluster is None else runner.cluster(cluster)
    if cluster is None:
        ensure_compiled(tell)
    whole, flights = sum(job.cost for job in jobs), len(jobs)
    done = [0, 0]
    with Journal(folder) as journal:
        known = set(journal.results)
        there = sum(job.key in known for job in jobs)
        if there:
            tell(f"{there} of {flights} flights are in {folder} already")

        def count(job: Job) -> None:
            done[0] += job.cost
            done[1] += 1
            progress(done[0] / whole, done[1], flights, job.key not in known)

        results = runner.finish(jobs, journal, engine, count)
    return write(study, jobs, results, folder)


def write(study: Study, jobs: Sequence[Job], results: Sequence[Result], folder: Path) -> Outcome:
    """Write `flights` and `summary` (CSV, Parquet), `series.parquet`, `study.json` and the figures."""
    from experiments.study.figures import draw  # noqa: PLC0415  matplotlib, after the flights

    table = rows(study, jobs, results)
    found = groups(study, table)
    statistics, columns = summary(study, found)
    flights = write_csv(folder / "flights.csv", table, list(types(study)))
    files = [flights, write_parquet(flights, types(study)), write_csv(folder / "summary.csv", statistics, columns)]
    if study.keeps_series:
        series = write_csv(folder / "series.csv", _series(study, jobs, results), list(SERIES))
        files.append(write_parquet(series, SERIES))
        series.unlink()  # long, and of use to programs only
    about = folder / "study.json"
    text = json.dumps({"study": study.model_dump(exclude_defaults=True), "code": grid.code_version()}, indent=1)
    about.write_text(text + "\n", encoding="utf-8")
    files += [about, *draw(study, jobs, results, table, folder)]
    return Outcome(study, statistics, verdicts(study, found), files)


SERIES = {"flight": "BIGINT", "t": "DOUBLE", "level_m": "DOUBLE"}


def _series(study: Study, jobs: Sequence[Job], results: Sequence[Result]) -> list[Row]:
    return [
        {"flight": job.index, "t": study.warmup + SERIES_INTERVAL * k, "level_m": level}
        for job, result in zip(jobs, results, strict=True)
        for k, level in enumerate(result.series)
    ]
