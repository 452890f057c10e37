"""How many files a process may have open: sockets and pipes count too."""

import contextlib
import resource

from formation.errors import EchelonError

WANTED = 4096
"""Enough for any run, with browsers."""
BASE, PER_PROCESS = 28, 2
"""What the launcher of a run has open, measured: its own, and of each process; no process of the run has more."""


def allow_more() -> None:
    """Raise this process's own limit as far as it may, for itself and for what it starts."""
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    wanted = WANTED if hard == resource.RLIM_INFINITY else min(WANTED, hard)
    if soft != resource.RLIM_INFINITY and soft < wanted:
        with contextlib.suppress(OSError, ValueError):
            resource.setrlimit(resource.RLIMIT_NOFILE, (wanted, hard))


def check_enough(processes: int) -> None:
    """Refuse a run of so many processes that would run out of files in the middle of its start.

    Raises:
        EchelonError: this process may not have so many files open.
    """
    needed, soft = BASE + PER_PROCESS * processes, resource.getrlimit(resource.RLIMIT_NOFILE)[0]
    if soft != resource.RLIM_INFINITY and soft < needed:
        raise EchelonError(f"expected a limit of at least {needed} open files for this run; got {soft} (ulimit -n)")
