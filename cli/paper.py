"""`echelon paper`: the paper's results again, and a report of them."""

import argparse
import json
import math
import sys
from collections.abc import Callable

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TaskID, TextColumn, TimeElapsedColumn
from rich.table import Table

from cli.options import tell
from formation.units import seconds
from runtime.precompile import ensure_compiled


def arguments(parser: argparse.ArgumentParser) -> None:
    """What the command accepts."""
    parser.add_argument("--out", metavar="DIR", default="echelon-paper", help="default: ./echelon-paper")
    parser.add_argument("--seed", type=_whole(0), default=0, metavar="S", help="the first one (default: 0)")
    parser.add_argument(
        "--seeds", type=_whole(1), default=2, metavar="N", help="with noise, per condition (default: 2)"
    )
    parser.add_argument("--duration", type=_time, metavar="T", help="cut every flight at T, such as 10s: a quick look")
    parser.add_argument("--workers", type=_whole(1), metavar="N", help="processes to fly in (default: one per core)")
    parser.add_argument("--json", action="store_true", help="print the tables and verdicts as one JSON object")


def run(options: argparse.Namespace) -> int:
    """Fly, draw, write; and say what holds."""
    from experiments.paper import paper  # noqa: PLC0415  matplotlib takes half a second to import, --help does without
    from experiments.paper.chapters import Extent  # noqa: PLC0415

    out = paper.folder(options.out)
    ensure_compiled(tell)
    extent = Extent(options.seed, options.seeds, options.duration)
    with _Bars() as progress:
        report = paper.write(out, extent, progress, options.workers)
    if options.json:
        print(json.dumps(paper.as_json(report), ensure_ascii=False))
        return 0
    table = Table("section", "claim", "verdict", show_lines=True)
    for section, verdict in report.verdicts():
        table.add_row(section.title, verdict.claim, verdict.outcome)
    console = Console()
    console.print(table, markup=False)
    console.print(f"{out / 'report.html'}", soft_wrap=True)
    return 0


class _Bars:
    """A progress bar per stage on a terminal; elsewhere a line per stage."""

    def __init__(self) -> None:
        self._shown = sys.stderr.isatty()
        self._bars = Progress(
            TextColumn("{task.description:>8}"),
            BarColumn(),
            MofNCompleteColumn(),
            TimeElapsedColumn(),
            console=Console(stderr=True),
            disable=not self._shown,
        )
        self._tasks: dict[str, TaskID] = {}

    def __enter__(self) -> Callable[[str, int, int], None]:
        self._bars.start()
        return self._tell

    def __exit__(self, *_: object) -> None:
        self._bars.stop()

    def _tell(self, stage: str, done: int, of: int) -> None:
        if stage not in self._tasks:
            self._tasks[stage] = self._bars.add_task(stage, total=of)
            if not self._shown:
                tell(f"{of} {stage} ...")
        self._bars.update(self._tasks[stage], completed=done, total=of)


def _whole(least: int) -> Callable[[str], int]:
    def read(text: str) -> int:
        if not text.isdecimal() or int(text) < least:
            raise argparse.ArgumentTypeError(f"expected a whole number from {least}; got {text!r}")
        return int(text)

    return read


def _time(text: str) -> float:
    try:
        value = float(str(seconds(text)))
    except ValueError as error:
        raise argparse.ArgumentTypeError(str(error)) from None
    if not (math.isfinite(value) and value >= 1.0):
        raise argparse.ArgumentTypeError(f"expected at least 1 s; got {text!r}")
    return value
