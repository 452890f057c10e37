"""Makes the keys of a run whose processes are started one by one, as containers are: of every role, in one folder."""

import argparse
import sys
from pathlib import Path

from formation.errors import EchelonError
from network.access.keys import Keys, common_name
from network.access.rules import members
from runtime.hosts.authority import Authority


def issue(folder: Path) -> bool:
    """Make what is not there. Returns False if every key is there already: they fit each other, and are in use."""
    names = ["router", *(common_name(role, number) for role, number in members())]
    try:
        for name in names:
            Keys.of(folder, name)
    except EchelonError:
        Authority().write(folder, *names)  # all of them: one authority signs for all
        return True
    return False


def main(arguments: list[str] | None = None) -> int:
    """Make the keys and end."""
    parser = argparse.ArgumentParser(prog="python -m runtime.hosts.issuing", description=__doc__)
    parser.add_argument("--folder", type=Path, required=True, help="private to the run's processes")
    options = parser.parse_args(arguments)
    try:
        issue(options.folder)
    except OSError as error:
        print(f"keys: expected a folder that can be written; {options.folder}: {error.strerror}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
