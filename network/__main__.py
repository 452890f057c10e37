"""The router process of a run."""

import argparse
import contextlib
import logging
import os
import shutil
import sys
import threading
from pathlib import Path

from formation.errors import EchelonError
from network.lifetime import Lifetime
from network.session import Router


def main(arguments: list[str] | None = None) -> int:
    """Listen until told to end."""
    parser = argparse.ArgumentParser(prog="python -m network", description=__doc__)
    parser.add_argument("--listen", required=True, help="unixsock-stream/PATH or tcp/HOST:PORT")
    parser.add_argument("--folder", help="the run's private folder, removed at the end")
    options = parser.parse_args(arguments)
    logging.basicConfig(format="%(name)s router: %(message)s", stream=sys.stderr)
    over = threading.Event()
    lifetime = Lifetime(over.set)
    try:
        router = Router(options.listen)
    except EchelonError as error:
        print(f"router: {error}", file=sys.stderr)
        return 2
    while not lifetime.over:
        over.wait(0.5)
    router.close()
    if options.folder:
        shutil.rmtree(options.folder, ignore_errors=True)
        if not os.environ.get("ECHELON_RUNS"):
            with contextlib.suppress(OSError):  # other runs are beside it
                Path(options.folder).parent.rmdir()
    return 0


if __name__ == "__main__":
    sys.exit(main())
