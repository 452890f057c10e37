"""The process of one robot's agent."""

import argparse
import logging
import sys

from agents.controllers.own import load_controller
from agents.process import run
from formation.errors import EchelonError
from network.arguments import add_connection, connect
from network.lifetime import Lifetime


def main(arguments: list[str] | None = None) -> int:
    """Answer ticks until the process is asked to end."""
    parser = argparse.ArgumentParser(prog="python -m agents", description=__doc__)
    add_connection(parser)
    parser.add_argument("--id", required=True, type=int, choices=range(1, 65), metavar="1..64", help="robot's number")
    parser.add_argument("--controller", action="append", default=[], metavar="FILE.py:CLASS", help="of your own")
    options = parser.parse_args(arguments)
    logging.basicConfig(format=f"%(name)s agent {options.id}: %(message)s", stream=sys.stderr)
    try:
        for spec in options.controller:
            load_controller(spec)
        with connect(options, "agent", options.id) as bus:
            run(bus, options.id, Lifetime(bus.wake))
    except EchelonError as error:
        print(f"agent {options.id}: {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
