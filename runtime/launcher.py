"""A run as supervised processes: start them, watch them, end them all and remove what they leave."""

import contextlib
import signal
import threading
from collections.abc import Callable
from types import TracebackType
from typing import Any, Self

from dashboard.serving.access import Guard
from formation.errors import EchelonError, WireError
from formation.formation_spec import MAX_ROBOTS
from formation.scenario.registry import check_live
from formation.scenario.scenario import Scenario
from network import topics
from network.bus import Sample
from network.codec import decode
from network.control import GetSummary
from network.messages import State
from network.zenoh_bus import ZenohBus
from runtime.open_files import check_enough
from runtime.precompile import ensure_compiled
from runtime.process_list import RunPlan, agent, programs
from runtime.run_registry import Claim
from runtime.supervisor import Supervisor
from runtime.user_code import packed

WATCH_SECONDS = 0.05
SUMMARY_SECONDS = 600.0
"""Longest wait for the measures of an episode [s]; those of 64 robots and an hour take many seconds."""


_ENDINGS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT)


def _interrupt(*_: object) -> None:
    raise KeyboardInterrupt


def _ignored() -> set[signal.Signals]:
    """Of nohup, which wants the run to outlive its terminal."""
    return {number for number in (signal.SIGHUP,) if signal.getsignal(number) is signal.SIG_IGN}


class LiveRun:
    """Processes of one run. Use as a context manager: leaving it ends them all."""

    def __init__(
        self,
        name: str,
        scenario: Scenario,
        *,
        tell: Callable[[str], None],
        **options: Any,
    ) -> None:
        """Without a name or a process yet.

        Args:
            name: of the run.
            scenario: what to run, already checked: the world gets this one, whatever becomes of its file.
            tell: called with a line for the user.
            options: of runtime.process_list.RunPlan.

        Raises:
            EchelonError: the controller cannot run as processes.
        """
        check_live(scenario.controller.name)
        self._scenario, self._tell = scenario, tell
        self._name, self._options = name, options
        self._claim: Claim | None = None
        self._supervisor = Supervisor(name, tell)
        self._handlers: dict[signal.Signals, Any] = {}
        self._session: ZenohBus | None = None
        self._state: State | None = None

    def __enter__(self) -> Self:
        """Claim the name and start the processes. Raises EchelonError: the name is in use, or it cannot be done."""
        # Also for Ctrl-C: a shell that starts a program in the background has it ignored.
        if threading.current_thread() is threading.main_thread():  # elsewhere Python allows no handlers
            endings = [number for number in _ENDINGS if number not in _ignored()]
            self._handlers = {number: signal.signal(number, _interrupt) for number in endings}
        try:
            self._plan = self._claimed()
            ensure_compiled(self._tell)
            wanted = programs(self._plan, self._scenario)
            check_enough(len(wanted))
            self._supervisor.start(wanted)
            self._session = ZenohBus(self._plan.connect, self._plan.run)
            self._session.subscribe(topics.state(self._plan.run))
            self._session.appear("launcher")
        except BaseException:
            self.__exit__(None, None, None)
            raise
        return self

    def _claimed(self) -> RunPlan:
        """Claim the name; what the run's processes need to know."""
        page = self._options.get("dashboard")
        address = Guard(page[0], self._options.get("token")).address(page[1]) if page else ""
        self._claim = claim = Claim(self._name, page=address)
        file = claim.path / "scenario.json"
        file.write_text(self._scenario.model_dump_json(exclude_unset=True), encoding="utf-8")
        options = {"folder": str(claim.path), "started": str(file), "code": packed(claim.path), **self._options}
        return RunPlan(self._name, str(file), claim.endpoint, claim.endpoint, **options)

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        for number in self._handlers:  # a second Ctrl-C must not interrupt the tidying up
            signal.signal(number, signal.SIG_IGN)
        if self._session is not None:  # before its router goes: closing a dead link takes long
            self._session.close()
        self._supervisor.stop()
        if self._claim is not None:
            self._claim.__exit__()
        for number, handler in self._handlers.items():
            signal.signal(number, handler)

    @property
    def page(self) -> str:
        """Address of its page; empty without one."""
        page = self._options.get("dashboard")
        return Guard(page[0], self._options.get("token")).address(page[1]) if page else ""

    @property
    def name(self) -> str:
        """Of the run."""
        return self._name

    @property
    def endpoint(self) -> str:
        """Of its router."""
        return self._plan.connect

    @property
    def state(self) -> State | None:
        """The newest State of the world."""
        return self._state

    def watch(self) -> bool:
        """Supervise the run for a moment. Returns False once the world was asked to stop.

        Raises:
            EchelonError: the world could not begin, or a process cannot be kept alive.
        """
        code = self._supervisor.watch(WATCH_SECONDS)
        if code is not None:
            if code:
                raise EchelonError(f"the world ended with exit code {code}")
            return False
        self._listen()
        if self._state is not None:
            robots = set(range(1, min(len(self._state.poses), MAX_ROBOTS) + 1))
            self._supervisor.keep_down(self._state.dismissed, "killed, as asked")
            surplus = self._supervisor.numbers - robots
            self._supervisor.keep_down(surplus, f"ended: the scenario has {len(robots)} robots")
            absent = set(self._state.waiting_for) - set(self._state.dismissed)
            missing = absent & robots - self._supervisor.numbers
            self._supervisor.start(agent(self._plan, number) for number in sorted(missing))
        return True

    def _listen(self) -> None:
        assert self._session is not None
        for item in self._session.arrivals():
            if isinstance(item, Sample):
                with contextlib.suppress(WireError):  # not a valid message; its receivers count it
                    self._state = decode(State, item.payload)

    def summary(self, warmup: float) -> dict[str, Any]:
        """The summary of the episode. Raises EchelonError if the world does not answer."""
        assert self._session is not None
        reply = self._session.ask(GetSummary(warmup=warmup), timeout=SUMMARY_SECONDS)
        if reply is None or not reply.ok:
            raise EchelonError(f"expected the summary of the episode; got {reply.reason if reply else 'no answer'}")
        return reply.value
