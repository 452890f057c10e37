"""The router process of a run."""

import argparse
import logging
import sys
from pathlib import Path
from time import monotonic, sleep

from formation.errors import EchelonError
from network.access.keys import Keys
from network.arguments import add_keys
from network.inbox import Inbox
from network.lifetime import Lifetime
from network.run_folder import remove
from network.zenoh_bus import Router

UNLOCK_SECONDS = 1.0
"""Longest time from the sight of a launcher's exit to the release of its locks [s]."""


def main(arguments: list[str] | None = None) -> int:
    """Route messages until the process is asked to end."""
    parser = argparse.ArgumentParser(prog="python -m network", description=__doc__)
    parser.add_argument("--listen", required=True, action="append", help="unixsock-stream/PATH, or tls/HOST:PORT")
    parser.add_argument("--run", default="", help="with --keys: name of the run")
    add_keys(parser)
    parser.add_argument("--folder", help="the run's private folder, removed at the end")
    options = parser.parse_args(arguments)
    logging.basicConfig(format="%(name)s router: %(message)s", stream=sys.stderr)
    wake: Inbox[None] = Inbox()
    lifetime = Lifetime(lambda: wake.put(None))
    try:
        keys = None if options.keys is None else Keys.of(options.keys, "router")
        router = Router(options.listen, options.run, keys=keys, insecure=options.insecure)
    except EchelonError as error:
        print(f"router: {error}", file=sys.stderr)
        return 2
    while not lifetime.over:
        wake.get()
    router.close()
    if options.folder:
        # A launcher that is alive removes it itself; one that is being killed holds the lock until it is gone.
        until = monotonic() + UNLOCK_SECONDS
        while not remove(Path(options.folder)) and lifetime.abandoned and monotonic() < until:
            sleep(0.02)
    return 0


if __name__ == "__main__":
    sys.exit(main())
