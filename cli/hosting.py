"""Options of a run that other hosts take part in."""

import argparse
from typing import TypedDict

from cli.options import tell
from formation.errors import EchelonError
from network.access.keys import PORT
from network.access.robot_numbers import parsed
from network.arguments import INSECURE
from runtime.hosts.listening import Listening
from runtime.launcher import LiveRun


class Hosting(TypedDict):
    """What a LiveRun needs to know of it."""

    listening: Listening | None
    here: frozenset[int] | None


def add_hosting(parser: argparse.ArgumentParser) -> None:
    """Where to listen, and which agents this host runs."""
    parser.add_argument("--agents", metavar="1-8", help="run agents of these robots only; others come from other hosts")
    parser.add_argument("--listen", metavar="HOST[:PORT]", help=f"for other hosts: echelon join (default port: {PORT})")
    parser.add_argument(
        "--transport",
        choices=["tcp", "udp"],
        default="tcp",
        help="of other hosts' agents; udp: what is lost stays lost (QUIC; plain with --insecure), for --realtime",
    )
    parser.add_argument("--insecure", action="store_true", help=f"with --listen, without keys: {INSECURE}")


def hosting(options: argparse.Namespace) -> Hosting:
    """What the options say. Raises EchelonError."""
    if options.listen is None:
        udp = options.transport == "udp"
        for name, given in (("--agents", options.agents), ("--insecure", options.insecure), ("--transport", udp)):
            if given:
                raise EchelonError(f"{name}: expected --listen HOST as well, for other hosts")
        return {"listening": None, "here": None}
    if options.transport == "udp" and not options.realtime:
        raise EchelonError("--transport udp: expected --realtime; in lockstep nothing may be lost")
    here = None if options.agents is None else parsed(options.agents)
    return {"listening": Listening.at(options.listen, options.transport, insecure=options.insecure), "here": here}


def tell_how_to_join(live: LiveRun, wish: Hosting) -> None:
    """Print what to type on another host."""
    listening = wish["listening"]
    if listening is None:
        return
    where = listening.named
    if live.reception is None:
        tell(f"--insecure: nothing is encrypted, and whoever reaches {where} can read and command the robots")
        udp = " --transport udp" if listening.transport == "udp" else ""
        tell(f"on another host: echelon join {where} --insecure{udp}")
    elif wish["here"] is not None:
        tell(f"on another host: echelon join {where} {live.reception.invite('agents')}")
        tell("the code is good once, for ten minutes; another one: echelon invite agents|operator|observer")
    else:
        tell(f"listens for other hosts at {where}; for a code: echelon invite operator|observer")
