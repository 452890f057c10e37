"""How many agents share a process: one each while the machine bears it, else as many processes as it has cores."""

import contextlib
from collections.abc import Callable
from multiprocessing.connection import Connection

from formation.errors import EchelonError
from runtime import fork_server
from runtime.machine.capacity import Capacity, cores, measured
from runtime.own_code import without_main

SURE = 4
"""Agents per core that any machine bears with a process each: fewer are not worth a second of measuring."""
MEASURE_SECONDS = 20.0
"""Longest wait for the measurement [s]."""


class Sharing:
    """Decides for one run."""

    def __init__(self, tell: Callable[[str], None], wished: int | None = None) -> None:
        """Nothing is measured yet.

        Args:
            tell: called with a line for the user.
            wished: agents in a process, whatever the machine bears.
        """
        self._tell, self._wished = tell, wished
        self._capacity: Capacity | None = None
        self._told = 1

    def size(self, robots: int) -> int:
        """Agents in a process, of so many that this machine runs. Raises EchelonError: nothing can be measured."""
        if self._wished is not None:
            return self._wished
        if robots <= SURE * cores():
            return 1
        found = self._capacity = self._capacity or _measured_aside()
        if robots <= found.alone:
            return 1
        size = -(-robots // found.cores)
        if size != self._told:
            self._told = size
            self._tell(
                f"{robots} agents: this machine bears about {found.alone} with a process each at 100 Hz, so up to "
                f"{size} share one (about {found.together} in all)"
            )
        return size


def _measured_aside() -> Capacity:
    """By a process of the fork server's, which has imported all that it takes."""
    ours, theirs = fork_server.context().Pipe(duplex=False)
    fork_server.start()
    process = fork_server.context().Process(target=_measure, args=(theirs,))
    try:
        with without_main(), fork_server.held_signals():
            process.start()
        theirs.close()  # here or above a Ctrl-C may come that was held: the process is ended all the same
        if not ours.poll(MEASURE_SECONDS):
            raise EchelonError("this machine does not answer in time when it is asked how many agents it bears")
        found: Capacity = ours.recv()
    except EOFError:
        raise EchelonError("how many agents this machine bears cannot be measured") from None
    finally:
        if process.pid is not None:
            process.kill()
            process.join()
    return found


def _measure(answer: "Connection[Capacity, Capacity]") -> None:
    with contextlib.suppress(BrokenPipeError):  # whoever asked is gone
        answer.send(measured())
