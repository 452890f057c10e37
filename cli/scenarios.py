"""`echelon scenarios`: the list of scenarios, and of the keys that a scenario may have."""

import argparse
import json
import sys

from rich.console import Console
from rich.table import Table
from rich.text import Text

from formation.errors import ScenarioError
from formation.scenario.files import load, shipped
from formation.scenario.keys import Key, matching

PLAIN_WIDTH = 150
"""Of tables that are not written to a terminal."""


def arguments(parser: argparse.ArgumentParser) -> None:
    """What the command accepts."""
    parser.add_argument(
        "--keys",
        nargs="?",
        const="",
        metavar="WORD",
        help="list the keys of a scenario instead, or those whose path has this word in it",
    )
    parser.add_argument("--json", action="store_true", help="print one JSON object")


def run(options: argparse.Namespace) -> None:
    """Print name, robots, duration and source of each; or the keys."""
    if options.keys is not None:
        _keys(options.keys, as_json=options.json)
        return
    found = [load(name) for name in shipped()]
    if options.json:
        rows = [{"name": s.name, "robots": s.size, "duration": s.duration, "source": s.source} for s in found]
        print(json.dumps({"scenarios": rows}))
        return
    table = Table("scenario", "robots", "path", "duration s", "what it is")
    for s in found:
        table.add_row(s.name, str(s.size), s.path.kind, f"{s.duration:g}", s.source)
    Console().print(table)


def _keys(word: str, *, as_json: bool) -> None:
    found = matching(word)
    if not found:
        raise ScenarioError(f"--keys: expected a part of a key such as link.latency; got {word!r}, which no key has")
    if as_json:
        print(json.dumps({"keys": [key._asdict() for key in found]}))
        return
    table = Table("key", "type", "unit", "range", "default", "what it is")
    for key in found:
        cells = (key.path, key.type, key.unit, key.range, key.default, _text(key))
        table.add_row(*map(Text, cells))  # brackets are units here, not styles
    Console(width=None if sys.stdout.isatty() else PLAIN_WIDTH).print(table)


def _text(key: Key) -> str:
    return f"({', '.join(key.of)}) {key.text}" if key.of else key.text
