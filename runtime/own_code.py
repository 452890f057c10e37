"""No process of ours imports code of the current folder or of the user's PYTHONPATH.

The names of our rooms are common words: a `network.py`, a `queue.py` or a package `agents` beside the user's scenario
would be imported in their place, and run. A process that is started with `python -c`, as multiprocessing starts its
own, looks into the current folder first, and this before any code of ours could prevent it: only its environment can.
"""

import contextlib
import os
import sysconfig
from collections.abc import Iterator
from pathlib import Path

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


def _set(values: dict[str, str | None]) -> None:
    for name, value in values.items():
        if value is None:
            os.environ.pop(name, None)
        else:
            os.environ[name] = value
