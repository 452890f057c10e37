"""The body process of a real robot."""

import argparse
import logging
import sys

from formation.errors import EchelonError
from network.arguments import add_connection, connect
from network.lifetime import Lifetime
from ros.body.process import run
from ros.spec import parse


def main(arguments: list[str] | None = None) -> int:
    """Drive a robot until the process is asked to end."""
    parser = argparse.ArgumentParser(prog="python -m ros.body", description=__doc__)
    add_connection(parser)
    parser.add_argument("--robot", required=True, help="N=ENDPOINT and options, as of `echelon up`")
    options = parser.parse_args(arguments)
    logging.basicConfig(format="%(name)s body: %(message)s", stream=sys.stderr)
    try:
        spec = parse(options.robot)
        with connect(options, "body", spec.number) as bus:
            run(bus, spec, Lifetime(bus.wake))
    except EchelonError as error:
        print(f"body: {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
