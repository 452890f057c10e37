"""The process of one robot's agent, or those of several."""

import argparse
import importlib
import logging
import sys

from agents.controllers.own import load_controller
from agents.process import run
from agents.several import run_each
from formation.errors import EchelonError
from formation.schema import MAX_ROBOTS
from network.access.robot_numbers import parsed, spelled
from network.arguments import add_connection, connect
from network.lifetime import Lifetime


def main(arguments: list[str] | None = None) -> int:
    """Answer ticks until the process is asked to end."""
    parser = argparse.ArgumentParser(prog="python -m agents", description=__doc__)
    add_connection(parser)
    who = parser.add_mutually_exclusive_group(required=True)
    who.add_argument(
        "--id", type=int, choices=range(1, MAX_ROBOTS + 1), metavar=f"1..{MAX_ROBOTS}", help="robot's number"
    )
    who.add_argument("--ids", metavar="1-8", help="robots' numbers: a process each, which share memory")
    parser.add_argument("--together", action="store_true", help="with --ids: one process for all; it has no --keys")
    parser.add_argument("--controller", action="append", default=[], metavar="FILE.py:CLASS", help="of your own")
    options = parser.parse_args(arguments)
    try:
        for spec in options.controller:
            load_controller(spec)
        if options.ids is None:
            return _agents(options, [options.id])
        robots = parsed(options.ids)
        if options.together:
            if options.keys is not None:
                raise EchelonError("--together: expected no --keys; the router knows agents one by one")
            return _agents(options, sorted(robots))
        importlib.import_module("agents.controllers.nash")  # with the kernels, which all then share
        return run_each(robots, lambda robot: _agents(options, [robot]))
    except EchelonError as error:
        print(f"agents: {error}", file=sys.stderr)
        return 2


def _agents(options: argparse.Namespace, robots: list[int]) -> int:
    name = f"agent{'s' if len(robots) > 1 else ''} {spelled(robots)}"
    logging.basicConfig(format=f"%(name)s {name}: %(message)s", stream=sys.stderr)
    try:
        with connect(options, "agent", robots[0]) as bus:
            run(bus, robots, Lifetime(bus.wake))
    except EchelonError as error:
        print(f"{name}: {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
