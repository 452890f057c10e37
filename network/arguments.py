"""How the processes of a run are told where their run is, and the keys that they show there."""

import argparse
import socket
import zlib
from pathlib import Path

from network.access.keys import Keys, common_name
from network.topics import Role
from network.zenoh_bus import CONNECT_SECONDS, ZenohBus

INSECURE = "use an endpoint that anybody who reaches it can read, and command the robots over"


def add_connection(parser: argparse.ArgumentParser) -> None:
    """The run, its router, and where the keys are."""
    parser.add_argument("--run", required=True, help="name of the run")
    parser.add_argument("--connect", required=True, help="the router's endpoint, such as tls/HOST:PORT")
    add_keys(parser)


def add_keys(parser: argparse.ArgumentParser) -> None:
    """Where the keys are, or that there are none."""
    parser.add_argument("--keys", type=Path, metavar="FOLDER", help="with the process's keys; a unix socket needs none")
    parser.add_argument("--insecure", action="store_true", help=INSECURE)


def host_number() -> int:
    """A number of this host or container by its name, which tells keepers of agents apart."""
    return zlib.crc32(socket.gethostname().encode())


def connect(options: argparse.Namespace, role: Role, number: int = 0, *, patience: float = CONNECT_SECONDS) -> ZenohBus:
    """Join the run in a role. Raises EchelonError."""
    keys = None if options.keys is None else Keys.of(options.keys, common_name(role, number))
    return ZenohBus(options.connect, options.run, keys=keys, insecure=options.insecure, patience=patience)
