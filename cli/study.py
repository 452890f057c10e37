"""`echelon study`: a grid of flights, its table, statistics and figures."""

import argparse
import json
import math
import os
import sys
import time
from collections.abc import Sequence
from pathlib import Path

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn
from rich.table import Table

from cli.options import tell
from experiments.study.study import Study, load, shipped
from experiments.study.table import Row
from formation.errors import StudyError

DEFAULT_OUT = "results"
PLAIN_SECONDS = 20.0
"""Between the lines that tell the progress where there is no terminal."""
SHOWN_ROWS = 60
PLAIN_WIDTH = 150
"""Of tables that are not written to a terminal."""
WHOLE = 1_000_000
"""Steps of the progress bar."""


def arguments(parser: argparse.ArgumentParser) -> None:
    """What the command accepts."""
    parser.add_argument("study", nargs="?", help="name or TOML file; without it, the studies there are")
    parser.add_argument("--list", action="store_true", help="list the studies")
    parser.add_argument("--workers", type=int, metavar="N", help="processes (default: one per core)")
    parser.add_argument("--cluster", metavar="ADDRESS", help="fly on the Dask cluster of this scheduler")
    parser.add_argument("--out", type=Path, metavar="DIR", help=f"for the results (default: {DEFAULT_OUT}/study-NAME)")
    parser.add_argument("--seeds", type=int, metavar="N", help="fly every point of the grid so often")
    parser.add_argument(
        "--set", action="append", default=[], metavar="KEY=VALUE", dest="settings", help="any key of the scenarios"
    )
    parser.add_argument("--json", action="store_true", help="print one JSON object")


def run(options: argparse.Namespace) -> int:
    """Fly what is missing, write the results, print the figures."""
    if options.list or options.study is None:
        _list(options.json)
        return 0
    for name in ("workers", "seeds"):
        if getattr(options, name) is not None and getattr(options, name) < 1:
            raise StudyError(f"--{name}: expected at least 1; got {getattr(options, name)}")
    if options.workers is not None and options.cluster is not None:
        raise StudyError("--workers: expected no number with --cluster; the cluster has its own")
    study = load(options.study, seeds=options.seeds, settings=options.settings)
    folder: Path = options.out or Path(DEFAULT_OUT) / f"study-{study.name}"
    from experiments.study.results import run_and_write  # noqa: PLC0415  with what flies; the list does without

    with _Progress(study.name) as progress:
        try:
            outcome = run_and_write(
                study,
                folder,
                workers=options.workers or _cores(),
                cluster=options.cluster,
                tell=tell,
                progress=progress.update,
            )
        except KeyboardInterrupt:
            progress.stop()
            tell("interrupted; the same command goes on where it stopped")
            raise
    if options.json:
        print(json.dumps(outcome.plain()))
        return 0
    _print(study, outcome.statistics, outcome.plain()["bounds"])
    for file in outcome.files:
        print(file)
    return 0


def _cores() -> int:
    """Cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def _list(as_json: bool) -> None:
    found = [load(name) for name in shipped()]
    if as_json:
        print(json.dumps({"studies": [{"name": s.name, "title": s.title, "flights": s.flights} for s in found]}))
        return
    table = Table("study", "flights", "what it asks")
    for study in found:
        table.add_row(study.name, str(study.flights), study.title)
    _console().print(table)


class _Progress:
    """A bar with the time left on a terminal, a line now and then elsewhere."""

    def __init__(self, name: str) -> None:
        self._terminal = sys.stderr.isatty()
        self._bar = Progress(
            TextColumn("{task.description}"),
            BarColumn(),
            TextColumn("{task.fields[flights]} flights"),
            TimeRemainingColumn(),
            console=Console(stderr=True),
            transient=True,
            disable=not self._terminal,
        )
        self._task = self._bar.add_task(name, total=WHOLE, flights="0")
        self._began: tuple[float, float] | None = None
        self._told = time.monotonic()

    def __enter__(self) -> "_Progress":
        self._bar.start()
        return self

    def __exit__(self, *_: object) -> None:
        self.stop()

    def stop(self) -> None:
        """Take the bar away."""
        self._bar.stop()

    def update(self, share: float, done: int, total: int, flying: bool) -> None:
        """So much is done.

        Args:
            share: of the work, 0 to 1; flights of many robots count more.
            done: flights.
            total: flights.
            flying: whether this was flown just now; else an earlier run had flown it.
        """
        self._bar.update(self._task, completed=share * WHOLE, flights=f"{done}/{total}")
        now = time.monotonic()
        if self._began is None or not flying:
            self._began = (now, share)  # what an earlier run had flown says nothing about the speed
            self._bar.reset(self._task, completed=round(share * WHOLE))
            return
        if not self._terminal and now - self._told >= PLAIN_SECONDS and share > self._began[1]:
            self._told = now
            left = (1.0 - share) * (now - self._began[0]) / (share - self._began[1])
            tell(f"{done} of {total} flights, about {_duration(left)} left")


def _duration(seconds: float) -> str:
    return f"{seconds:.0f} s" if seconds < 90.0 else f"{seconds / 60.0:.0f} min"


def _print(study: Study, statistics: Sequence[Row], bounds: Sequence[dict[str, object]]) -> None:
    """The first measure at every point of the grid (and the recovery, if it is one), then the bounds."""
    console = _console()
    columns = [name for name, labels in study.labels.items() if len(labels) > 1]
    for measure in [m for m in study.measures if m == study.measures[0] or m == "recovery_s"]:
        rows = [row for row in statistics if row["measure"] == measure]
        unit, factor = ("mm", 1e3) if rows[0]["unit"] == "m" else (str(rows[0]["unit"]), 1.0)
        ratio = study.baseline and any(row["ratio"] is not None for row in rows)
        table = Table(
            *columns, f"{measure.rpartition('_')[0]} {unit}", "95 %", "max", *(["ratio", "95 %"] if ratio else [])
        )
        for row in rows[:SHOWN_ROWS]:
            cells = [str(row[name]) for name in columns]
            cells += [
                _number(row["mean"], factor),
                _range(row["low"], row["high"], factor),
                _number(row["max"], factor),
            ]
            if row["missing"]:
                cells[-3] += f" ({row['missing']} of {row['flights']} never)"
            if ratio:
                cells += [_number(row["ratio"]), _range(row["ratio_low"], row["ratio_high"])]
            table.add_row(*cells)
        console.print(table)
        if len(rows) > SHOWN_ROWS:
            console.print(f"... {len(rows) - SHOWN_ROWS} more in summary.csv")
    for bound in bounds:
        console.print(_verdict(bound), markup=False, highlight=False)


def _console() -> Console:
    return Console(width=None if sys.stdout.isatty() else PLAIN_WIDTH)


def _verdict(bound: dict[str, object]) -> str:
    where = ", ".join(f"{k} {v}" for k, v in dict(bound["where"]).items())  # type: ignore[call-overload]
    found = "never" if bound["found"] is None else _number(bound["found"])
    why = f" ({bound['why']})" if bound["why"] else ""
    words = "holds" if bound["holds"] else "DOES NOT HOLD"
    limit = f"at least {bound['at_least']}" if bound["at_most"] is None else f"at most {bound['at_most']}"
    return f"{words}: {bound['statistic']} of {bound['measure']} at {where}: {found}, {limit}{why}"


def _number(value: object, factor: float = 1.0) -> str:
    return f"{value * factor:.4g}" if isinstance(value, int | float) and math.isfinite(value) else "-"


def _range(low: object, high: object, factor: float = 1.0) -> str:
    return f"{_number(low, factor)} to {_number(high, factor)}" if low != high else "-"
