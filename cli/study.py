"""`echelon study`: a grid of trials, its table, statistics and figures."""

import argparse
import json
import sys
from collections.abc import Sequence
from pathlib import Path

from rich.console import Console
from rich.table import Table

from cli.light_options import add_controllers
from cli.options import add_workers, check_workers, controllers, tell
from cli.terminal.figures import figure
from cli.terminal.progress import TrialProgress
from experiments.study.controllers import with_controllers
from experiments.study.study import Study, load, shipped
from experiments.study.table import Row
from formation.errors import StudyError
from formation.loading.source import LOADED
from formation.scenario.overrides import from_settings

DEFAULT_OUT = "results"
SHOWN_ROWS = 60
PLAIN_WIDTH = 150
"""Of tables that are not written to a terminal."""


def arguments(parser: argparse.ArgumentParser) -> None:
    """What the command accepts."""
    parser.add_argument("study", nargs="?", help="name or TOML file; without it, the studies there are")
    parser.add_argument("--list", action="store_true", help="list the studies")
    add_workers(parser)
    parser.add_argument("--out", type=Path, metavar="DIR", help=f"for the results (default: {DEFAULT_OUT}/study-NAME)")
    add_controllers(parser)
    parser.add_argument("--seeds", type=int, metavar="N", help="trials of every point of the grid")
    parser.add_argument(
        "--set", action="append", default=[], metavar="KEY=VALUE", dest="settings", help="any key of the scenarios"
    )
    parser.add_argument("--json", action="store_true", help="print one JSON object")


def run(options: argparse.Namespace) -> int:
    """Simulate what is missing, write the results, print the statistics."""
    if options.list or options.study is None:
        _list(options.json)
        return 0
    if options.seeds is not None and options.seeds < 1:
        raise StudyError(f"--seeds: expected at least 1; got {options.seeds}")
    check_workers(options)
    study = load(options.study, seeds=options.seeds, overrides=from_settings(options.settings))
    names = controllers(options)
    if names:
        study = with_controllers(study, names)
        if options.cluster is not None and any(("controller", name) in LOADED for name in names):
            tell("the text of your own controllers goes to the workers of the cluster, which run it")
    folder: Path = options.out or Path(DEFAULT_OUT) / f"study-{study.name}"
    from experiments.study.results import run_and_write  # noqa: PLC0415  with the engine; the list does without
    from experiments.trials.batch import Place  # noqa: PLC0415

    place = Place(folder, options.workers, options.cluster)
    with TrialProgress(study.name, place.cores) as progress:
        outcome = run_and_write(study, place, tell=tell, progress=progress.trials)
    if options.json:
        print(json.dumps(outcome.plain()))
        return 0
    _print(study, outcome.statistics, outcome.plain()["bounds"])
    for file in outcome.files:
        print(file)
    return 0


def _list(as_json: bool) -> None:
    found = [load(name) for name in shipped()]
    if as_json:
        print(json.dumps({"studies": [{"name": s.name, "title": s.title, "trials": s.trials} for s in found]}))
        return
    table = Table("study", "trials", "what it asks")
    for study in found:
        table.add_row(study.name, str(study.trials), study.title)
    _console().print(table)


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
                figure(row["mean"], factor),
                _range(row["low"], row["high"], factor),
                figure(row["max"], factor),
            ]
            if row["missing"]:
                cells[-3] += f" ({row['missing']} of {row['trials']} never)"
            if ratio:
                cells += [figure(row["ratio"]), _range(row["ratio_low"], row["ratio_high"])]
            table.add_row(*cells)
        console.print(table)
        if len(rows) > SHOWN_ROWS:
            console.print(f"... {len(rows) - SHOWN_ROWS} more in summary.csv")
    for bound in bounds:
        console.print(_check(bound), markup=False, highlight=False)


def _console() -> Console:
    return Console(width=None if sys.stdout.isatty() else PLAIN_WIDTH)


def _check(bound: dict[str, object]) -> str:
    where = ", ".join(f"{k} {v}" for k, v in dict(bound["where"]).items())  # type: ignore[call-overload]
    found = "never" if bound["found"] is None else figure(bound["found"])
    why = f" ({bound['why']})" if bound["why"] else ""
    words = "holds" if bound["holds"] else "DOES NOT HOLD"
    limit = f"at least {bound['at_least']}" if bound["at_most"] is None else f"at most {bound['at_most']}"
    return f"{words}: {bound['statistic']} of {bound['measure']} at {where}: {found}, {limit}{why}"


def _range(low: object, high: object, factor: float = 1.0) -> str:
    return f"{figure(low, factor)} to {figure(high, factor)}" if low != high else "-"
