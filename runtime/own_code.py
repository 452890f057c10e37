"""No process of ours imports code of the current folder or of the user's PYTHONPATH, or the user's script.

The names of our rooms are common words: a `network.py`, a `queue.py` or a package `agents` beside the user's scenario
would be imported in their place, and run. A process that is started with `python -c`, as multiprocessing starts its
own, looks into the current folder first, and this before any code of ours could prevent it: only its environment can.

And multiprocessing has each process import the main module, for functions and classes of it: ours need none, and a
script without `if __name__ == "__main__":` would begin again in every one of them.
"""

import contextlib
import multiprocessing
import multiprocessing.spawn
import os
import sysconfig
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from formation.errors import EchelonError

ROOT = Path(__file__).parents[1]
"""The folder of this code: a checkout, or the site-packages that it is installed in."""


def variables() -> dict[str, str | None]:
    """What an own process has in its environment; None: not set."""
    installed = str(ROOT) in (sysconfig.get_path("purelib"), sysconfig.get_path("platlib"))
    # Installed packages must stay behind Python's own modules, where they are found without being named.
    return {"PYTHONSAFEPATH": "1", "PYTHONPATH": None if installed else str(ROOT)}


@contextlib.contextmanager
def own_code() -> Iterator[None]:
    """Python processes that are started meanwhile import our code and installed packages only."""
    before = {name: os.environ.get(name) for name in variables()}
    _set(variables())
    try:
        yield
    finally:
        _set(before)


_here = threading.local()
"""Whether the processes that this thread starts do without the main module; others are not ours."""
_prepared = multiprocessing.spawn.get_preparation_data


def _prepared_for(name: str) -> dict[str, Any]:
    """What multiprocessing tells a new process first."""
    told = _prepared(name)
    if getattr(_here, "without_main", False):
        for key in ("init_main_from_name", "init_main_from_path"):
            told.pop(key, None)
    return told


multiprocessing.spawn.get_preparation_data = _prepared_for


@contextlib.contextmanager
def without_main() -> Iterator[None]:
    """Processes that this thread starts meanwhile, by a fork server or anew, do not import the main module."""
    before = getattr(_here, "without_main", False)
    _here.without_main = True
    try:
        yield
    finally:
        _here.without_main = before


def check_main(what: str) -> None:
    """Refuse to start processes while this one, of the user's own, imports the main module. Raises EchelonError."""
    if getattr(multiprocessing.current_process(), "_inheriting", False):
        raise EchelonError(
            f'{what}: expected a script that does its work below `if __name__ == "__main__":`; a process of '
            "multiprocessing imports it just now, and would begin it again"
        )


def _set(values: dict[str, str | None]) -> None:
    for name, value in values.items():
        if value is None:
            os.environ.pop(name, None)
        else:
            os.environ[name] = value
