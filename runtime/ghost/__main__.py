"""The ghost process of a run."""

import argparse
import logging
import sys

from agents.controllers.own import load_controller
from formation.errors import EchelonError
from network.arguments import add_connection, connect
from network.lifetime import Lifetime
from runtime.ghost.process import run
from world.bodies.own import load_bodies


def main(arguments: list[str] | None = None) -> int:
    """Follow the run until the process is asked to end."""
    parser = argparse.ArgumentParser(prog="python -m runtime.ghost", description=__doc__)
    add_connection(parser)
    parser.add_argument("--controller", action="append", default=[], metavar="FILE.py:CLASS", help="of your own")
    parser.add_argument("--bodies", action="append", default=[], metavar="FILE.py:CLASS", help="of your own")
    options = parser.parse_args(arguments)
    logging.basicConfig(format="%(name)s ghost: %(message)s", stream=sys.stderr)
    try:
        for spec in options.controller:
            load_controller(spec)
        for spec in options.bodies:
            load_bodies(spec)
        with connect(options, "ghost") as bus:
            run(bus, Lifetime(bus.wake))
    except EchelonError as error:
        print(f"ghost: {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
