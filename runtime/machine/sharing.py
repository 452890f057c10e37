"""How many agents share a process: one each while they are few, else as many processes as the machine has cores.

In lockstep few is SURE a core. With more, a process a core is quicker, for most of a tick is then messages: 16 robots
on two cores make 1.3 to 3 times the ticks, with 40 % of the processor time. In real time few is what the machine bears.
"""

import contextlib
from collections.abc import Callable
from multiprocessing.connection import Connection

from formation.errors import EchelonError
from runtime import fork_server
from runtime.machine.capacity import Capacity, cores, measured
from runtime.own_code import without_main

SURE = 4
"""Agents per core that have a process each on any machine: fewer are not worth a second of measuring."""
MEASURE_SECONDS = 20.0
"""Longest wait for the measurement [s]."""


class Sharing:
    """Decides for one run."""

    def __init__(self, tell: Callable[[str], None], wished: int | None = None, *, lockstep: bool = False) -> None:
        """Nothing is measured yet.

        Args:
            tell: called with a line for the user.
            wished: agents in a process, whatever else holds.
            lockstep: the run waits for slow agents.
        """
        self._tell, self._wished, self._lockstep = tell, wished, lockstep
        self._capacity: Capacity | None = None
        self._told = 1

    def size(self, robots: int) -> int:
        """Agents in a process, of so many that this machine runs. Raises EchelonError: nothing can be measured."""
        if self._wished is not None:
            return self._wished
        if robots <= SURE * cores():
            return 1
        if self._lockstep:
            return self._shared(robots, cores(), "in lockstep a process a core is quicker than one each", "")
        found = self._capacity = self._capacity or _measured_aside()
        if robots <= found.alone:
            return 1
        why = f"this machine bears about {found.alone} with a process each at 100 Hz"
        return self._shared(robots, found.cores, why, f" (about {found.together} in all)")

    def _shared(self, robots: int, processes: int, why: str, more: str) -> int:
        """Agents in a process of so many, which the user is told."""
        size = -(-robots // processes)
        if size != self._told:
            self._told = size
            self._tell(f"{robots} agents: {why}, so up to {size} share one{more}")
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
