"""`echelon scenarios`: the list of scenarios."""

import argparse
import json

from rich.console import Console
from rich.table import Table

from formation.scenario.files import load, shipped


def arguments(parser: argparse.ArgumentParser) -> None:
    """What the command accepts."""
    parser.add_argument("--json", action="store_true", help="print one JSON object")


def run(options: argparse.Namespace) -> None:
    """Print name, robots, duration and source of each."""
    found = [load(name) for name in shipped()]
    if options.json:
        rows = [{"name": s.name, "robots": s.size, "duration": s.duration, "source": s.source} for s in found]
        print(json.dumps({"scenarios": rows}))
        return
    table = Table("scenario", "robots", "path", "duration s", "what it is")
    for s in found:
        table.add_row(s.name, str(s.size), s.path.kind, f"{s.duration:g}", s.source)
    Console().print(table)
