"""The process of one robot's agent, or those of several."""

import argparse
import importlib
import logging
import sys

from agents.controllers.own import load_controller
from agents.process import run
from agents.several import run_each
from formation.errors import EchelonError
from network.access.robot_numbers import parsed
from network.arguments import add_connection, connect
from network.lifetime import Lifetime


def main(arguments: list[str] | None = None) -> int:
    """Answer ticks until the process is asked to end."""
    parser = argparse.ArgumentParser(prog="python -m agents", description=__doc__)
    add_connection(parser)
    who = parser.add_mutually_exclusive_group(required=True)
    who.add_argument("--id", type=int, choices=range(1, 65), metavar="1..64", help="robot's number")
    who.add_argument("--ids", metavar="1-8", help="robots' numbers: a process each, which share memory")
    parser.add_argument("--controller", action="append", default=[], metavar="FILE.py:CLASS", help="of your own")
    options = parser.parse_args(arguments)
    try:
        for spec in options.controller:
            load_controller(spec)
        if options.ids is None:
            return _one(options, options.id)
        robots = parsed(options.ids)
        importlib.import_module("agents.controllers.nash")  # with the kernels, which all then share
        return run_each(robots, lambda robot: _one(options, robot))
    except EchelonError as error:
        print(f"agents: {error}", file=sys.stderr)
        return 2


def _one(options: argparse.Namespace, robot: int) -> int:
    logging.basicConfig(format=f"%(name)s agent {robot}: %(message)s", stream=sys.stderr)
    try:
        with connect(options, "agent", robot) as bus:
            run(bus, robot, Lifetime(bus.wake))
    except EchelonError as error:
        print(f"agent {robot}: {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
