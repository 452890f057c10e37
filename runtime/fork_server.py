"""The fork server that all processes of a run come from: they share its memory, and start without importing anything.

Its imports take as long as the command's own (about a second), so it is started first: both go on side by side.
"""

import multiprocessing
import multiprocessing.forkserver
import os
from multiprocessing.context import ForkServerContext

from agents.kernels.jit_cache import compiled
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


def context() -> ForkServerContext:
    """What processes are made with, once `start` has started the fork server."""
    for variable, value in ENVIRONMENT.items():
        os.environ.setdefault(variable, value)
    found = multiprocessing.get_context("forkserver")
    found.set_forkserver_preload(["runtime.preload"])
    return found


def start() -> None:
    """Start the fork server if it does not run yet. It ends with this process."""
    context()
    with own_code():
        multiprocessing.forkserver.ensure_running()


def start_early() -> None:
    """Start the fork server now, unless it would have to compile the solver."""
    if compiled():
        start()
