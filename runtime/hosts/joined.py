"""What a host that joined a run of another one runs: the agents that it was let in for."""

from collections.abc import Callable
from functools import partial
from pathlib import Path
from types import TracebackType
from typing import Self

from network import topics
from network.access.keys import AUTHORITY, Keys, common_name
from network.bus import Connection, Presence
from network.zenoh_bus import ZenohBus
from runtime.endings import Endings
from runtime.hosts.authority import write_private
from runtime.hosts.enrolment import Admission
from runtime.keeping.agent_keeper import AgentKeeper
from runtime.keeping.states import newest
from runtime.precompile import ensure_compiled
from runtime.process_list import RunPlan, agents
from runtime.run_registry import Claim, free_name
from runtime.supervisor import Supervisor
from runtime.user_code import packed

WATCH_SECONDS = 0.05
"""Between two looks at the run [s]."""
GONE_SECONDS = 10.0
"""A run whose router or launcher is gone for this long is over [s]: a router that was killed is back within one."""


def write_keys(folder: Path, admission: Admission) -> None:
    """What was got for a code, as the processes read it."""
    write_private(folder / AUTHORITY, admission.authority)
    for name, certificate in admission.certificates.items():
        write_private(folder / f"{name}.pem", certificate)
        write_private(folder / f"{name}.key", admission.key)


class JoinedRun:
    """This host's part of a run. Use as a context manager: leaving it ends its processes."""

    def __init__(
        self,
        run: str,
        endpoint: str,
        robots: frozenset[int],
        *,
        admission: Admission | None,
        tell: Callable[[str], None],
    ) -> None:
        """Without a process yet.

        Args:
            run: its name.
            endpoint: of its router, for agents.
            robots: whose agents this host runs.
            admission: with the keys; None for an endpoint that strangers can use.
            tell: called with a line for the user.
        """
        self._run, self._endpoint, self._admission, self._tell = run, endpoint, admission, tell
        self.robots = robots
        self._supervisor = Supervisor(run, tell)
        self._endings = Endings()
        self._claim: Claim | None = None
        self._session: ZenohBus | None = None
        self._connected = self._launched = True
        self._gone = 0.0

    def __enter__(self) -> Self:
        """Write the keys and start the agents. Raises EchelonError."""
        self._endings.begin()
        try:
            ensure_compiled(self._tell)
            self._claim = Claim(free_name(f"{self._run}-joined"), joined=True)
            folder = self._claim.path / "keys"
            insecure = self._admission is None
            if self._admission is not None:
                write_keys(folder, self._admission)
            plan = RunPlan(
                self._run,
                "",
                self._endpoint,
                (),
                keys=None if insecure else str(folder),
                insecure=insecure,
                code=packed(self._claim.path),
            )
            keys = None if insecure else Keys.of(folder, common_name("agent", min(self.robots)))
            # What this process hears it hears as one of its agents.
            self._session = ZenohBus(self._endpoint, self._run, keys=keys, insecure=insecure)
            self._session.subscribe(topics.state(self._run))
            self._session.watch()
            self._keeper = AgentKeeper(self._supervisor, partial(agents, plan))
            self._supervisor.start(agents(plan, self.robots))
        except BaseException:
            self.__exit__(None, None, None)
            raise
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._endings.ignore()
        if self._session is not None:
            self._session.close()
        self._supervisor.stop()
        if self._claim is not None:
            self._claim.__exit__()
        self._endings.end()

    def watch(self) -> bool:
        """Supervise the agents for a moment. Returns False once the run is over.

        Raises:
            EchelonError: an agent cannot be kept alive.
        """
        self._supervisor.watch(WATCH_SECONDS)
        assert self._session is not None
        arrivals = self._session.arrivals()
        for item in arrivals:
            match item:
                case Presence("launcher", _, here):
                    self._launched = here
                case Connection(up):
                    self._connected = up
                case _:
                    pass
        state = newest(arrivals)
        if state is not None:
            self._keeper.keep(state, self.robots)
        self._gone = 0.0 if self._connected and self._launched else self._gone + WATCH_SECONDS
        return self._gone < GONE_SECONDS
