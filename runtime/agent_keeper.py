"""Which agents a host keeps alive, by the world's newest State."""

from collections.abc import Callable, Iterable

from formation.schema import MAX_ROBOTS
from network.messages import State
from runtime.process_list import Program
from runtime.supervisor import Supervisor


class AgentKeeper:
    """Starts agents that are missing, and ends those that are not wanted."""

    def __init__(
        self,
        supervisor: Supervisor,
        agents: Callable[[Iterable[int]], Iterable[Program]],
        here: frozenset[int] | None = None,
    ) -> None:
        """Without a State yet.

        Args:
            supervisor: of this host's processes.
            agents: the processes of some robots' agents.
            here: robots whose agents this host runs; None: all.
        """
        self._supervisor, self._agents, self._here = supervisor, agents, here

    def keep(self, state: State) -> None:
        """Do as the world wishes: agents of robots of its scenario, but of none that users keep down."""
        robots = set(range(1, min(len(state.poses), MAX_ROBOTS) + 1))
        own = robots if self._here is None else robots & self._here
        self._supervisor.keep_down(state.dismissed, "killed, as asked")
        surplus = self._supervisor.numbers - robots
        self._supervisor.keep_down(surplus, f"ended: the scenario has {len(robots)} robots")
        absent = set(state.waiting_for) - set(state.dismissed)
        missing = absent & own - self._supervisor.numbers
        if missing:
            self._supervisor.start(self._agents(missing))
