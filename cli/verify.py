"""`echelon verify`: simulate a record again and compare every pose to the last bit."""

import argparse
from pathlib import Path

from cli.light_options import add_controllers
from cli.options import controllers, tell
from records.record import load
from runtime.precompile import ensure_compiled
from runtime.user_code import named


def arguments(parser: argparse.ArgumentParser) -> None:
    """What the command accepts."""
    add_controllers(parser)
    parser.add_argument("--bodies", metavar="FILE.py:CLASS", help="code of your own that moved the bodies")
    parser.add_argument("file", type=Path, metavar="FILE", help="a record (.mcap) of a lockstep run")


def run(options: argparse.Namespace) -> int:
    """Print what came of it; 1 if anything differs."""
    record = load(options.file)
    ensure_compiled(tell)
    controllers(options)
    if options.bodies:
        named(options.bodies, "bodies")
    from runtime.verification import verify  # noqa: PLC0415  half a second, for numba

    verdicts = verify(record)
    for verdict in verdicts:
        result = f"differs first at {verdict.difference}" if verdict.difference else "every bit is equal"
        remark = f" ({verdict.remark})" if verdict.remark else ""
        print(f"episode {verdict.episode}: {verdict.ticks} ticks up to t = {verdict.until:.2f} s: {result}{remark}")
    return 1 if any(verdict.difference for verdict in verdicts) else 0
