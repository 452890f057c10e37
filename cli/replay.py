"""`echelon replay`: a record on the page, to drag, play and step; a second one is its ghost."""

import argparse
from functools import partial
from pathlib import Path

from cli.light_options import DEFAULT_PORT, LOOPBACK, add_controllers
from dashboard.serving import access
from dashboard.serving.access import Guard


def arguments(parser: argparse.ArgumentParser) -> None:
    """What the command accepts."""
    parser.add_argument("file", type=Path, metavar="FILE", help="a record (.mcap), also one that is damaged")
    parser.add_argument("other", type=Path, metavar="FILE2", nargs="?", help="another one, shown as the ghost of it")
    parser.add_argument("--port", type=int, default=DEFAULT_PORT, help=f"of the page (default: {DEFAULT_PORT}; 0: any)")
    parser.add_argument(
        "--host", default=LOOPBACK, help="to serve the page on (default: loopback); others demand a token"
    )
    parser.add_argument("--token", help=f"that browsers must send; ${access.TOKEN} hides it from ps")
    parser.add_argument(
        "--agent", type=int, metavar="N", help="no page: `recording agent` of robot N, with --controller another one"
    )
    parser.add_argument("--json", action="store_true", help="with --agent: print JSON")
    add_controllers(parser)


def run(options: argparse.Namespace) -> None:
    """Serve the page until Ctrl-C, or run one agent anew."""
    if options.agent is not None:
        from cli.recording import run_agent  # noqa: PLC0415  as long as the page takes to start

        options.robot = options.agent
        run_agent(options)
        return
    from runtime.replay.process import serve  # noqa: PLC0415  half a second, for the page

    token = access.given_token(options.token)
    if token is None and options.host not in access.LOOPBACK:
        token = access.new_token()
    serve(Guard(options.host, token), options.port, options.file, options.other, partial(print, flush=True))
