"""The private folder of a run: whoever leads the run holds a lock in it, and it is removed when nobody does."""

import contextlib
import fcntl
import os
import shutil
from pathlib import Path
from typing import IO

VARIABLE = "ECHELON_RUNS"
"""Environment variable that names another place for the folders of runs."""
_LOCK = "lock"


def lock(path: Path) -> IO[bytes] | None:
    """The lock of a run's folder; None if somebody holds it, or the folder is gone. A killed process holds nothing."""
    try:
        file = (path / _LOCK).open("ab")
    except OSError:
        return None
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        if os.fstat(file.fileno()).st_ino == (path / _LOCK).stat().st_ino:
            return file  # and not a folder that somebody removed and made again meanwhile
    except OSError:
        pass
    file.close()
    return None


def remove(path: Path, held: IO[bytes] | None = None) -> None:
    """Remove the folder if nobody else holds its lock, and the place of all runs if it was the last.

    Args:
        path: the run's folder.
        held: its lock, if the caller holds it; it is released.
    """
    file = held or lock(path)
    if file is None:
        return
    shutil.rmtree(path, ignore_errors=True)
    file.close()
    if not os.environ.get(VARIABLE):
        with contextlib.suppress(OSError):  # other runs are in it
            path.parent.rmdir()
