"""Which agents a host keeps alive, by the world's newest State."""

from collections.abc import Callable, Iterable, Set

from formation.schema import MAX_ROBOTS
from network.messages import State
from runtime.process_list import Program
from runtime.supervisor import Supervisor


class AgentKeeper:
    """Starts agents that are missing, and ends those that are not wanted."""

    def __init__(self, supervisor: Supervisor, agents: Callable[[Iterable[int]], Iterable[Program]]) -> None:
        """Without a State yet.

        Args:
            supervisor: of this host's processes.
            agents: the processes of some robots' agents.
        """
        self._supervisor, self._agents = supervisor, agents

    def keep(self, state: State, here: Set[int] | None = None) -> None:
        """Do as the world wishes: agents of robots of its scenario, but of none that users keep down.

        Args:
            state: the newest.
            here: robots whose agents this host runs; None: all.
        """
        robots = set(range(1, min(len(state.poses), MAX_ROBOTS) + 1))
        own = robots if here is None else robots & here
        self._keep_down(state.dismissed, "killed, as asked")
        self._keep_down(self._supervisor.numbers - robots, f"ended: the scenario has {len(robots)} robots")
        self._keep_down(self._supervisor.numbers - own, "ended: another host runs it now")
        absent = set(state.waiting_for) - set(state.dismissed)
        missing = absent & own - self._supervisor.numbers
        if missing:
            self._supervisor.start(self._agents(missing))

    def _keep_down(self, robots: Iterable[int], why: str) -> None:
        self._supervisor.keep_down(robots, why, self._agents)
