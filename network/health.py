"""Whether a process of a run has its liveliness token; for the health checks of containers."""

import argparse
import sys

from formation.errors import EchelonError
from network.arguments import add_connection, connect, host_number
from network.bus import Bus, Presence

SECONDS = 3.0

ROLES = ("router", "world", "agent", "keeper", "recorder", "ghost", "dashboard", "body", "display")
"""Of processes that may be containers."""


def main(arguments: list[str] | None = None) -> int:
    """Exit code 0 if it is alive, 1 if not."""
    parser = argparse.ArgumentParser(prog="python -m network.health", description=__doc__)
    add_connection(parser)
    parser.add_argument("--role", required=True, choices=ROLES)
    parser.add_argument("--id", type=int, default=0)
    options = parser.parse_args(arguments)
    number = host_number() if options.role == "keeper" else options.id
    try:
        with connect(options, "observer") as session:
            return 0 if options.role == "router" or _seen(session, options.role, number) else 1
    except EchelonError as error:
        print(error, file=sys.stderr)
        return 1


def _seen(session: Bus, role: str, number: int) -> bool:
    session.watch()
    wanted = Presence(role, number, here=True)
    return any(item == wanted for item in session.incoming(SECONDS))


if __name__ == "__main__":
    sys.exit(main())
