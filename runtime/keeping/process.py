"""The process that runs the agents of a run where no launcher does: in containers, alone or as one of several."""

from collections.abc import Callable, Iterable
from types import TracebackType
from typing import Self

from network import topics
from network.access.rules import MAX_KEYED
from network.bus import Bus, Presence
from runtime.keeping.agent_keeper import AgentKeeper
from runtime.keeping.shares import Shares
from runtime.keeping.states import newest
from runtime.process_list import Program
from runtime.supervisor import Supervisor

WATCH_SECONDS = 0.05
"""Between two looks at the run [s]."""


class Keeper:
    """Runs this keeper's share of the agents. Use as a context manager: leaving it ends them."""

    def __init__(
        self,
        bus: Bus,
        number: int,
        agents: Callable[[Iterable[int]], Iterable[Program]],
        tell: Callable[[str], None],
    ) -> None:
        """Without an agent yet.

        Args:
            bus: its session with the run.
            number: of this keeper, which no other has.
            agents: the processes of some robots' agents.
            tell: called with a line for the user.
        """
        self._bus, self._number = bus, number
        self._shares = Shares(number)
        self._supervisor = Supervisor(bus.run, tell)
        self._keeper = AgentKeeper(self._supervisor, agents)

    def __enter__(self) -> Self:
        self._bus.watch()
        self._bus.subscribe(topics.state(self._bus.run))
        self._bus.appear("keeper", self._number)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._supervisor.stop()

    def watch(self) -> None:
        """Keep the agents for a moment. Raises EchelonError: one cannot be kept alive."""
        self._supervisor.watch(WATCH_SECONDS)
        arrivals = self._bus.arrivals()
        for item in arrivals:
            if isinstance(item, Presence) and item.role == "keeper":
                self._shares.note(item.number, here=item.here)
        state = newest(arrivals)
        if state is not None:
            self._keeper.keep(state, self._shares.of(range(1, MAX_KEYED + 1)))
