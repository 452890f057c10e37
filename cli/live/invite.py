"""`echelon invite`: a new code for somebody on another host."""

import argparse

from formation.errors import EchelonError
from network.access.keys import AUTHORITY
from runtime.hosts.codes import GUESTS, Codes
from runtime.hosts.reception import FOLDER
from runtime.run_registry import find, folder


def arguments(parser: argparse.ArgumentParser) -> None:
    """What the command accepts."""
    parser.add_argument("guest", choices=GUESTS, help="hosts with agents; who gives orders; who only listens")
    parser.add_argument("--run", metavar="NAME", help="the run (default: the only live one)")


def run(options: argparse.Namespace) -> None:
    """Print the code."""
    name = find(options.run).name
    keys = folder() / name / FOLDER
    if not (keys / AUTHORITY).is_file():
        raise EchelonError(f"expected a run that listens for other hosts (echelon up --listen); {name} does not")
    print(Codes(keys).new(options.guest, (keys / AUTHORITY).read_text()))
