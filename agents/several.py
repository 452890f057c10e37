"""Several agents from one command: a process each, forked from one that has imported all they need.

They share its memory, and each has a session and keys of its own, as the router knows agents one by one. A process that
ends is started again; all end with the first.
"""

import multiprocessing
import signal
import sys
from collections.abc import Callable, Iterable
from multiprocessing.connection import wait
from multiprocessing.context import ForkProcess

RESTART_SECONDS = 0.2
"""Delay before a process that ended is started again [s]."""
LOOK_SECONDS = 1.0
"""Longest wait [s]: a signal that comes just before it begins does not end it."""
MAX_DEATHS = 20
"""Processes that end so often end all: something is wrong that no restart mends."""
STOP_SECONDS = 3.0
"""Time from SIGTERM to SIGKILL [s]."""


class _StopError(Exception):
    """The end is due."""


def run_each(robots: Iterable[int], run: Callable[[int], int]) -> int:
    """Be the agents of several robots until this process is asked to end.

    Args:
        robots: their numbers.
        run: the agent of one, to be called in a process of its own; returns the exit code.

    Returns:
        The exit code: 0, or that of an agent that cannot be kept alive.
    """
    context = multiprocessing.get_context("fork")

    def started(robot: int) -> ForkProcess:
        process = context.Process(target=_enter, args=(run, robot))
        process.start()
        return process

    signal.signal(signal.SIGTERM, _stop)
    signal.signal(signal.SIGINT, _stop)
    running: dict[int, ForkProcess] = {}
    deaths = 0
    try:
        for robot in sorted(robots):
            running[robot] = started(robot)
        while True:
            wait([process.sentinel for process in running.values()], timeout=LOOK_SECONDS)
            for robot in [robot for robot, process in running.items() if process.exitcode is not None]:
                code = running[robot].exitcode or 0
                deaths += 1
                if code == 2 or deaths > MAX_DEATHS:  # a mistake of the user's, which a line tells
                    return code or 1
                wait([process.sentinel for process in running.values()], timeout=RESTART_SECONDS)
                running[robot] = started(robot)
    except _StopError:
        return 0
    finally:
        signal.signal(signal.SIGTERM, signal.SIG_IGN)
        signal.signal(signal.SIGINT, signal.SIG_IGN)
        for process in running.values():
            process.terminate()
        for process in running.values():
            process.join(STOP_SECONDS)
            process.kill()


def _stop(*_: object) -> None:
    raise _StopError


def _enter(run: Callable[[int], int], robot: int) -> None:
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    sys.exit(run(robot))
