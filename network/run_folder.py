"""The private folder of a run: its launcher holds a lock in it; the folder is removed once nobody holds the lock."""

import contextlib
import fcntl
import os
import shutil
from pathlib import Path
from typing import IO

VARIABLE = "ECHELON_RUNS"
"""Environment variable for another parent folder of the runs' folders."""
_LOCK = "lock"


def lock(path: Path) -> IO[bytes] | None:
    """The lock of a run's folder; None if another process holds it, or if the folder does not exist.

    The lock of a killed process is free.
    """
    try:
        file = (path / _LOCK).open("ab")
    except OSError:
        return None
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        if os.fstat(file.fileno()).st_ino == (path / _LOCK).stat().st_ino:
            return file  # and not a folder that was removed and made again meanwhile
    except OSError:
        pass
    file.close()
    return None


def remove(path: Path, held: IO[bytes] | None = None) -> bool:
    """Remove the folder if no other process holds its lock, and its parent folder if it was the last.

    It gets another name first: a world that still saves its run there finds no folder, and so adds nothing to it.

    Args:
        path: the run's folder.
        held: its lock, if the caller holds it; it is released.

    Returns:
        Whether there is no such folder now.
    """
    file = held or lock(path)
    if file is None:
        return not path.exists()
    unnamed = path.with_name(f".removed-{path.name}-{os.getpid()}")
    with contextlib.suppress(OSError):
        path.rename(unnamed)
    shutil.rmtree(unnamed, ignore_errors=True)
    file.close()
    if not os.environ.get(VARIABLE):
        with contextlib.suppress(OSError):  # other runs are in it
            path.parent.rmdir()
    return not path.exists()
