"""The dashboard process of a run."""

import argparse
import logging
import sys
from pathlib import Path

from dashboard.page import Page
from dashboard.scenario_list import ScenarioList
from dashboard.serving import access, server
from formation.errors import EchelonError
from formation.scenario.files import load
from network.arguments import add_connection, connect
from network.lifetime import Lifetime


def main(arguments: list[str] | None = None) -> int:
    """Serve the page until the process is told to stop."""
    parser = argparse.ArgumentParser(prog="python -m dashboard", description=__doc__)
    add_connection(parser)
    parser.add_argument("--port", type=_port, default=8090, help="8090 by default; 0: any free one")
    parser.add_argument("--host", default="127.0.0.1", help="any other than loopback requires a token")
    parser.add_argument("--token", help=f"that browsers must send; ${access.TOKEN} hides it from ps")
    parser.add_argument("--started", type=Path, metavar="FILE", help="the scenario that the run was started with")
    parser.add_argument("--scenarios", type=Path, metavar="FOLDER", help="whose scenarios the page offers as well")
    options = parser.parse_args(arguments)
    logging.basicConfig(format="%(name)s dashboard: %(message)s", stream=sys.stderr)
    try:
        guard = access.Guard(options.host, access.given_token(options.token))
        started = None if options.started is None else load(str(options.started))
        scenarios = ScenarioList(started, options.scenarios)
        served = server.serve(guard, options.port, "Run control")
        lifetime = Lifetime()
        try:
            with connect(options, "dashboard") as bus:
                page = Page(served, bus, scenarios)
                port = served.get_port()
                where = "" if options.host in access.LOOPBACK else f" (listens on {options.host}:{port})"
                print(f"dashboard: {guard.address(port)}{where}", flush=True)
                page.serve(lifetime)
        finally:
            server.stop(served)
    except EchelonError as error:
        print(f"dashboard: {error}", file=sys.stderr)
        return 2
    return 0


def _port(text: str) -> int:
    if not text.isascii() or not text.isdigit() or int(text) > 65535:
        raise argparse.ArgumentTypeError(f"expected a port from 0 to 65535; got {text!r}")
    return int(text)


if __name__ == "__main__":
    sys.exit(main())
