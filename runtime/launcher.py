"""A run as supervised processes: start them, watch them, end them all and remove what they leave."""

from collections.abc import Callable, Iterable
from dataclasses import replace
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any, Self

from dashboard.serving.access import Guard
from formation.errors import EchelonError
from formation.scenario.registry import check_live
from formation.scenario.scenario import Scenario
from network import topics
from network.access.robot_numbers import spelled
from network.access.rules import MAX_KEYED
from network.control import GetSummary
from network.messages import State
from network.zenoh_bus import ZenohBus
from runtime.endings import Endings
from runtime.hosts.listening import Listening
from runtime.keeping.agent_keeper import AgentKeeper
from runtime.keeping.states import newest
from runtime.machine.sharing import Sharing
from runtime.open_files import check_enough
from runtime.precompile import ensure_compiled
from runtime.process_list import Program, RunPlan, agents, programs, recorder
from runtime.record_keeper import RecordKeeper, broken
from runtime.run_registry import Claim
from runtime.supervisor import Supervisor
from runtime.user_code import packed

if TYPE_CHECKING:
    from runtime.hosts.reception import Reception

WATCH_SECONDS = 0.05
SUMMARY_SECONDS = 600.0
"""Longest wait for the measures of an episode [s]; those of 64 robots and an hour take many seconds."""


class LiveRun:
    """Processes of one run. Use as a context manager: leaving it ends them all."""

    def __init__(
        self,
        name: str,
        scenario: Scenario,
        *,
        tell: Callable[[str], None],
        listening: Listening | None = None,
        here: frozenset[int] | None = None,
        together: int | None = None,
        **options: Any,
    ) -> None:
        """Without a name or a process yet.

        Args:
            name: of the run.
            scenario: what to run, already checked: the world gets this one, whatever becomes of its file.
            tell: called with a line for the user.
            listening: for other hosts.
            here: robots whose agents this host runs; None: all.
            together: agents in a process; None: what runtime/machine/sharing.py finds.
            options: of runtime.process_list.RunPlan.

        Raises:
            EchelonError: the controller cannot run as processes, or there would be too many elsewhere.
        """
        check_live(scenario.controller.name)
        distant = set() if here is None else set(range(1, scenario.size + 1)) - here
        if distant and max(distant) > MAX_KEYED:
            raise EchelonError(
                f"--agents: expected agents of other hosts up to robot {MAX_KEYED}; {spelled(distant)} would be theirs"
            )
        self._scenario, self._tell = scenario, tell
        self._name, self._options = name, options
        self._claim: Claim | None = None
        self._supervisor = Supervisor(name, tell)
        self._sharing = Sharing(tell, together, lockstep=not options.get("realtime", False))
        self._endings = Endings()
        self._listening, self._here = listening, here
        self.reception: Reception | None = None
        """Lets other hosts in; None if the run does not listen, or if nobody is asked for a code."""
        self._session: ZenohBus | None = None
        self._state: State | None = None

    def __enter__(self) -> Self:
        """Claim the name and start the processes. Raises EchelonError: the name is in use, or it cannot be done."""
        self._endings.begin()
        try:
            self._plan = self._claimed()
            ensure_compiled(self._tell)
            wanted = programs(self._shared(self._scenario.size), self._scenario)
            check_enough(len(wanted))
            self._keeper = AgentKeeper(self._supervisor, self._agents)
            folder = Path(self._plan.scenarios or ".").absolute()
            self._records = RecordKeeper(self._supervisor, lambda file: recorder(self._plan, file), folder, self._tell)
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
        endpoints: tuple[str, ...] = (claim.endpoint,)
        if self._listening is not None:
            endpoints += self._listening.endpoints
            options["insecure"] = self._listening.insecure
            if not self._listening.insecure:
                from runtime.hosts.reception import Reception  # noqa: PLC0415  cryptography costs a start on one host 0.1 s

                self.reception = Reception(self._listening, self._name, claim.path, self._vacant, self._tell)
                options["keys"] = str(self.reception.folder)
        return RunPlan(self._name, str(file), claim.endpoint, endpoints, here=self._here, **options)

    def _shared(self, robots: int) -> RunPlan:
        """The plan of a run of so many robots, of which some may share a process."""
        here = robots if self._here is None else len(self._here.intersection(range(1, robots + 1)))
        return replace(self._plan, together=self._sharing.size(here))

    def _agents(self, missing: Iterable[int]) -> list[Program]:
        """Processes of agents that are missing, or whose process ended with another's."""
        robots = len(self._state.poses) if self._state else self._scenario.size
        return agents(self._shared(robots), missing)

    def _vacant(self) -> set[int]:
        """Robots whose agents are other hosts' to run, and not there."""
        state = self._state
        robots = range(1, (self._scenario.size if state is None else len(state.poses)) + 1)
        here = set(robots) if self._here is None else self._here
        return {robot for robot in robots if robot <= MAX_KEYED} - here - set(state.live if state else ())

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._endings.ignore()
        if self.reception is not None:
            self.reception.close()
        if self._session is not None:  # before its router goes: closing a dead link takes long
            self._session.close()
        self._supervisor.stop()
        if self._claim is not None:
            self._claim.__exit__()
        self._endings.end()

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

    @property
    def record_fault(self) -> str:
        """Why the record that the run was started with is not whole, once the run is over; empty if it is, or none."""
        file = self._options.get("record")
        codes = [] if file is None else self._supervisor.codes[recorder(self._plan, file)]
        return "" if not any(codes) else broken(codes)

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
            self._keeper.keep(self._state, self._here)
            self._records.keep(self._state)
        return True

    def _listen(self) -> None:
        assert self._session is not None
        self._state = newest(self._session.arrivals()) or self._state

    def summary(self, warmup: float) -> dict[str, Any]:
        """The summary of the episode. Raises EchelonError if the world does not answer."""
        assert self._session is not None
        reply = self._session.ask(GetSummary(warmup=warmup), timeout=SUMMARY_SECONDS)
        if reply is None or not reply.ok:
            raise EchelonError(f"expected the summary of the episode; got {reply.reason if reply else 'no answer'}")
        return reply.value
