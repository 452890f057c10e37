"""The recorder process of a run."""

import argparse
import logging
import sys
from pathlib import Path

from formation.errors import EchelonError
from network.arguments import add_connection, connect
from network.lifetime import Lifetime
from records.process import run


def main(arguments: list[str] | None = None) -> int:
    """Record the run until the process is asked to end; 0 if all of it is in the file."""
    parser = argparse.ArgumentParser(prog="python -m records", description=__doc__)
    add_connection(parser)
    parser.add_argument("--file", required=True, type=Path, help="to write to")
    parser.add_argument("--detail", choices=["default", "full"], default="default", help="what is recorded")
    options = parser.parse_args(arguments)
    logging.basicConfig(format="%(name)s recorder: %(message)s", stream=sys.stderr)
    try:
        with connect(options, "recorder") as bus:
            whole = run(bus, options.file, Lifetime(bus.wake), detail=options.detail)
    except EchelonError as error:
        print(f"recorder: {error}", file=sys.stderr)
        return 2
    return 0 if whole else 1


if __name__ == "__main__":
    sys.exit(main())
