"""`echelon recording`: what a record holds, a broken one made whole, its tables."""

import argparse
from pathlib import Path

from rich.console import Console
from rich.table import Table

from records.export import export
from records.record import Record, load
from records.repair import repair


def arguments(parser: argparse.ArgumentParser) -> None:
    """What the command accepts."""
    actions = parser.add_subparsers(dest="action", metavar="info|repair|export", required=True)
    info = actions.add_parser("info", help="what the file holds, and whether it is whole")
    mend = actions.add_parser("repair", help="write what can be read into a new file that every reader reads")
    mend.add_argument("--out", type=Path, metavar="FILE", help="the new file (default: NAME-repaired.mcap)")
    tables = actions.add_parser("export", help="write poses and errors as tables beside the file")
    kinds = tables.add_mutually_exclusive_group()
    kinds.add_argument("--csv", dest="kind", action="store_const", const="csv", help="as CSV (the default)")
    kinds.add_argument("--parquet", dest="kind", action="store_const", const="parquet", help="as Parquet")
    for action in (info, mend, tables):
        action.add_argument("file", type=Path, metavar="FILE", help="a record (.mcap)")


def run(options: argparse.Namespace) -> None:
    """Do it."""
    match options.action:
        case "info":
            _print(load(options.file))
        case "repair":
            new = options.out or options.file.with_stem(f"{options.file.stem}-repaired")
            done = repair(options.file, new)
            lost = f"{done.lost} bytes in {done.places} places cannot be read" if done.lost else "nothing is lost"
            print(f"{done.path}: {done.messages} messages; {lost}")
        case "export":
            for file in export(load(options.file), options.kind or "csv"):
                print(file)


def _print(record: Record) -> None:
    console, about = Console(), record.about
    size = record.path.stat().st_size
    console.print(
        f"{record.path}: run {about['run']}, detail {about['detail']}, wire version {about['version']}, "
        f"{size / 1e6:.2f} MB, {sum(record.counts.values())} messages",
        markup=False,
    )
    if not record.sound:
        lost = sum(damage.length for damage in record.damage)
        console.print(
            f"not whole: {lost} bytes cannot be read{'' if record.ended else ', and there is no index'} "
            "(echelon recording repair)"
        )
    for number, episode in enumerate(record.episodes, 1):
        ticks = episode.ticks
        span = f"ticks {ticks[0]} to {ticks[-1]}" if ticks else "no ticks"
        what = f"{episode.mode}, controller {episode.controller}, {episode.seconds(episode.ends):.2f} s, {span}"
        console.print(f"episode {number}: {what}, {len(episode.orders)} orders")
    table = Table("topic", "messages")
    for topic, count in sorted(record.counts.items()):
        table.add_row(topic, str(count))
    console.print(table)
