"""The process that shows a run to ROS 2."""

import argparse
import logging
import sys

from formation.errors import EchelonError
from network.arguments import add_connection, connect
from network.lifetime import Lifetime
from ros.display.process import run


def main(arguments: list[str] | None = None) -> int:
    """Show a run until the process is asked to end."""
    parser = argparse.ArgumentParser(prog="python -m ros.display", description=__doc__)
    add_connection(parser)
    parser.add_argument("--ros", required=True, help="endpoint of the router of ROS 2")
    parser.add_argument("--domain", type=int, default=0, help="ROS_DOMAIN_ID")
    parser.add_argument("--real", type=int, action="append", default=[], metavar="N", help="a robot that is real")
    options = parser.parse_args(arguments)
    logging.basicConfig(format="%(name)s display: %(message)s", stream=sys.stderr)
    try:
        with connect(options, "display") as bus:
            run(bus, options.ros, options.domain, options.real, Lifetime(bus.wake))
    except EchelonError as error:
        print(f"display: {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
