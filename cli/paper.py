"""`echelon paper`: the paper's results again, and a report of them."""

import argparse
import json
import math
from collections.abc import Callable

from rich.console import Console
from rich.table import Table

from cli.options import add_workers, check_workers, tell
from cli.terminal.progress import TrialProgress
from formation.units import seconds


def arguments(parser: argparse.ArgumentParser) -> None:
    """What the command accepts."""
    parser.add_argument("--out", metavar="DIR", default="echelon-paper", help="default: ./echelon-paper")
    parser.add_argument("--seed", type=_whole(0), default=0, metavar="S", help="the first one (default: 0)")
    parser.add_argument(
        "--seeds", type=_whole(1), default=2, metavar="N", help="with noise, per condition (default: 2)"
    )
    parser.add_argument("--duration", type=_time, metavar="T", help="cut every trial at T, such as 10s: a quick look")
    add_workers(parser)
    parser.add_argument("--json", action="store_true", help="print the tables and verdicts as one JSON object")


def run(options: argparse.Namespace) -> int:
    """Simulate, draw, write, and print the verdicts."""
    from experiments.paper import paper  # noqa: PLC0415  matplotlib takes half a second to import, --help does without
    from experiments.paper.chapters import Extent  # noqa: PLC0415
    from experiments.trials.batch import Place  # noqa: PLC0415

    check_workers(options)
    out = paper.folder(options.out)
    extent = Extent(options.seed, options.seeds, options.duration)
    place = Place(out, options.workers, options.cluster)
    with TrialProgress("paper", place.cores) as progress:
        report = paper.write(extent, place, tell=tell, trials=progress.trials, figures=progress.figures)
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
