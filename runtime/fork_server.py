"""The fork server that all processes of a run come from: they share its memory, and start without importing anything.

Its imports take as long as the command's own (about a second), so it is started first: both go on side by side.
"""

import contextlib
import multiprocessing
import multiprocessing.forkserver
import multiprocessing.resource_tracker
import os
import signal
from collections.abc import Iterator
from multiprocessing.context import ForkServerContext

from agents.kernels.jit_cache import compiled
from runtime.open_files import allow_more
from runtime.own_code import own_code

_ZENOH_STAGES = ("app", "acc", "net", "rx", "tx")
ENVIRONMENT = {
    **dict.fromkeys(("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS"), "1"),
    "SPT_NOENV": "1",
    "ZENOH_RUNTIME": "(" + ", ".join(f"{stage}: (worker_threads: 1)" for stage in _ZENOH_STAGES) + ")",
}
"""For the processes of a run: small matrices gain nothing from threads, and threads do not survive a fork; and a
process with two or three links is served faster by one thread per stage of Zenoh than by several; and titles leave the
environment readable from outside."""


_BLOCKED = {signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT}
"""Nothing but its launcher's end ends the fork server: no Ctrl-C, no closed terminal, which reach a whole
group of processes. The processes of a run inherit this; runtime/supervisor.py unblocks what they heed."""


def context() -> ForkServerContext:
    """What processes are made with, once `start` has started the fork server."""
    for variable, value in ENVIRONMENT.items():
        os.environ.setdefault(variable, value)
    allow_more()
    found = multiprocessing.get_context("forkserver")
    found.set_forkserver_preload(["runtime.preload"])
    return found


@contextlib.contextmanager
def held_signals() -> Iterator[None]:
    """What would end this process waits meanwhile."""
    before = signal.pthread_sigmask(signal.SIG_BLOCK, _BLOCKED)
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def start() -> None:
    """Start the fork server if it does not run yet. It ends with this process."""
    context()
    with own_code():
        multiprocessing.resource_tracker.ensure_running()  # or it would unblock signals below
        with held_signals():
            multiprocessing.forkserver.ensure_running()


def start_early() -> None:
    """Start the fork server now, unless it would have to compile the solver."""
    if compiled():
        start()
