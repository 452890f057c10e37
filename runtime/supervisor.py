"""Starts the processes of a run, restarts those that die, and leaves none behind."""

import gc
import importlib
import signal
import sys
from collections import defaultdict, deque
from collections.abc import Callable, Iterable
from multiprocessing.connection import wait
from multiprocessing.process import BaseProcess
from time import monotonic

from setproctitle import setproctitle

from formation.errors import EchelonError
from network.access.robot_numbers import spelled
from network.lifetime import TERMINATED
from runtime import fork_server
from runtime.own_code import without_main
from runtime.process_list import Program

STOP_SECONDS = 3.0
"""Time from SIGTERM to SIGKILL [s]."""
RESTART_SECONDS = 0.2
"""Delay before a dead process is started again [s]."""
MAX_DEATHS, DEATH_WINDOW = 5, 10.0
"""A process that dies more often than this within the window [s] ends the run."""


class Supervisor:
    """The processes of one run."""

    def __init__(self, run: str, tell: Callable[[str], None]) -> None:
        """Without any process yet.

        Args:
            run: its name, for the processes' titles.
            tell: called with a line for the user when a process dies and is restarted.
        """
        self._run, self._tell = run, tell
        self._context = fork_server.context()
        self._running: dict[Program, BaseProcess] = {}
        self._again: dict[Program, float] = {}
        self._deaths: dict[Program, deque[float]] = {}
        self.codes: defaultdict[Program, list[int]] = defaultdict(list)
        """With which each program's processes have ended so far; below 0: by which signal."""

    @property
    def numbers(self) -> set[int]:
        """Robots that have an agent, or will have one again."""
        return {robot for program in (*self._running, *self._again) for robot in program.robots}

    def start(self, programs: Iterable[Program]) -> None:
        """Start processes."""
        for program in programs:
            fork_server.start()
            process = self._context.Process(
                target=_enter, args=(program.module, program.arguments, f"echelon {self._run}: {program.name}")
            )
            with (
                without_main(),
                fork_server.held_signals(),
            ):  # a process that is started is known, or nobody would end it
                process.start()
                self._running[program] = process

    def keep_down(self, numbers: Iterable[int], why: str, agents: Callable[[Iterable[int]], Iterable[Program]]) -> None:
        """Kill the agents of these robots, and do not bring them back; `start` does.

        Args:
            numbers: of the robots.
            why: for the user.
            agents: the processes of the agents of some robots: of others that share one with them.
        """
        down = set(numbers)
        for program in [program for program in self._again if program.robots & down]:
            at = self._again.pop(program)
            self._again |= dict.fromkeys(agents(program.robots - down), at)
        for program in [program for program in self._running if program.robots & down]:
            process = self._running.pop(program)
            process.kill()
            process.join(STOP_SECONDS)
            others = list(agents(program.robots - down))
            self._again |= dict.fromkeys(others, monotonic())
            again = ", ".join(other.name for other in others)
            shared = f", with its process; starting again: {again}" if again else ""
            self._tell(f"agent {spelled(program.robots & down)} {why}{shared}")

    @property
    def roles(self) -> set[str]:
        """Of the processes that run, or will run again."""
        return {program.role for program in (*self._running, *self._again)}

    def end(self, role: str) -> list[int]:
        """Ask the processes of a role to end, and do not bring them back; their codes, as in `codes`."""
        for program in [program for program in self._again if program.role == role]:
            del self._again[program]
        ended = {program: process for program, process in self._running.items() if program.role == role}
        for program, process in ended.items():
            del self._running[program]
            process.terminate()
        until = monotonic() + STOP_SECONDS
        return [self._ended(program, process, until) for program, process in ended.items()]

    def _ended(self, program: Program, process: BaseProcess, until: float) -> int:
        """The code of a process that was asked to end, killed if it still runs at a time of the monotonic clock [s]."""
        process.join(max(0.0, until - monotonic()))
        if process.exitcode is None:
            process.kill()
            process.join(1.0)
        code = -signal.SIGKILL if process.exitcode is None else process.exitcode
        self.codes[program].append(code)
        return code

    def watch(self, seconds: float) -> int | None:
        """Supervise the processes for some time. Returns the world's exit code once it has ended by itself.

        Raises:
            EchelonError: a process died again and again.
        """
        until = monotonic() + seconds
        while True:
            now = monotonic()
            due = [program for program, at in self._again.items() if at <= now]
            for program in due:
                del self._again[program]
            self.start(due)
            pause = max(0.0, min([until - now, *(at - now for at in self._again.values())]))
            wait([process.sentinel for process in self._running.values()], timeout=pause)
            for program, process in list(self._running.items()):
                if process.exitcode is not None:
                    del self._running[program]
                    self.codes[program].append(process.exitcode)
                    if program.role == "world" and process.exitcode >= 0 and process.exitcode != TERMINATED:
                        return process.exitcode
                    self._bury(program, process.exitcode)
            if monotonic() >= until:
                return None

    def _bury(self, program: Program, code: int) -> None:
        now = monotonic()
        deaths = self._deaths.setdefault(program, deque(maxlen=MAX_DEATHS))
        if len(deaths) == MAX_DEATHS and now - deaths[0] < DEATH_WINDOW:
            raise EchelonError(f"{program.name} ended {MAX_DEATHS + 1} times in {DEATH_WINDOW:g} s: giving up")
        deaths.append(now)
        self._again[program] = now + RESTART_SECONDS
        self._tell(f"{program.name} ended ({_cause(code)}): starting it again")

    def stop(self) -> None:
        """End every process: the router's clients first, the router last, by SIGKILL those that do not end."""
        self._again.clear()
        last = [program for program in self._running if program.role == "router"]
        first = [program for program in self._running if program.role != "router"]
        for group in (first, last):
            for program in group:
                self._running[program].terminate()
            until = monotonic() + STOP_SECONDS
            for program in group:
                self._ended(program, self._running[program], until)
        self._running.clear()


def _cause(code: int) -> str:
    return f"signal {-code}" if code < 0 else f"exit code {code}"


def _enter(module: str, arguments: tuple[str, ...], title: str) -> None:
    """Entry of one process, in a child of the fork server."""
    gc.enable()
    signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGTERM})
    setproctitle(title)
    sys.exit(importlib.import_module(f"{module}.__main__").main(list(arguments)))
