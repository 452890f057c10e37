"""Options of commands that show something at once: what they need is imported in a moment."""

import argparse

from formation.scenario.registry import names

DEFAULT_PORT = 8090
"""Of the page."""
LOOPBACK = "127.0.0.1"


def add_controllers(parser: argparse.ArgumentParser) -> None:
    """Controllers by name, or code of one's own; the first one drives, the others can be chosen and compared."""
    parser.add_argument(
        "--controller",
        action="append",
        metavar="NAME|FILE.py:CLASS",
        help=f"{', '.join(names())}, or one of your own; given again, another one to choose or to compare with",
    )
