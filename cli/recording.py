"""`echelon recording`: what a record holds, a broken one made whole, its tables."""

import argparse
import json
from dataclasses import asdict
from pathlib import Path

from rich.console import Console
from rich.table import Table

from cli.light_options import add_controllers
from cli.options import controllers, tell
from records.export import export
from records.record import Record, load
from records.repair import repair
from runtime.precompile import ensure_compiled


def arguments(parser: argparse.ArgumentParser) -> None:
    """What the command accepts."""
    actions = parser.add_subparsers(dest="action", metavar="info|repair|export|agent", required=True)
    info = actions.add_parser("info", help="what the file holds, and whether it is whole")
    mend = actions.add_parser("repair", help="write what can be read into a new file that every reader reads")
    mend.add_argument("--out", type=Path, metavar="FILE", help="the new file (default: NAME-repaired.mcap)")
    tables = actions.add_parser("export", help="write poses and errors as tables beside the file")
    kinds = tables.add_mutually_exclusive_group()
    kinds.add_argument("--csv", dest="kind", action="store_const", const="csv", help="as CSV (the default)")
    kinds.add_argument("--parquet", dest="kind", action="store_const", const="parquet", help="as Parquet")
    one = actions.add_parser("agent", help="run one robot's agent anew on what it got, and compare its commands")
    one.add_argument("--robot", type=int, required=True, metavar="N", help="whose agent")
    add_controllers(one)
    one.add_argument("--json", action="store_true", help="print JSON")
    for action in (info, mend, tables, one):
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
        case "agent":
            run_agent(options)


def run_agent(options: argparse.Namespace) -> None:
    """Run one agent anew and print how its commands differ."""
    record = load(options.file)
    ensure_compiled(tell)
    chosen = controllers(options)
    from runtime.one_agent import rerun  # noqa: PLC0415  half a second, for numba

    found = rerun(record, options.robot, chosen[0] if chosen else "")
    if options.json:
        print(json.dumps(asdict(found)))
        return
    same = "every command is equal" if found.first is None else f"commands differ from t = {found.first:.2f} s on"
    (v, omega), (rms_v, rms_omega) = found.largest, found.rms
    print(
        f"robot {options.robot}, {found.ticks} ticks: {same}; v by at most {v:.3g} m/s (RMS {rms_v:.3g}), omega by at "
        f"most {omega:.3g} rad/s (RMS {rms_omega:.3g}); {found.failures} ticks without a solution of its own"
    )


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
