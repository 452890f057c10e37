"""Agents of several robots that share a process and a session, without I/O: arrivals and a time in, actions out.

What comes in is decoded once for all of them, and what one of them says to another comes in at once. Each stays a node
of its own, so that a run is the same, to the last bit, whoever shares a process.
"""

from collections.abc import Collection, Iterable

from agents.node import ASK_SECONDS, AgentNode
from agents.states import State
from formation.errors import WireError
from network import topics
from network.bus import Action, Announce, Ask, Incoming, Publish, Read, Response, Sample, Subscribe, Unsubscribe
from network.codec import decode
from network.messages import Plan, Tick
from network.requests import Setup


class Crew:
    """The nodes of several robots."""

    def __init__(self, run: str, robots: Iterable[int], *, pid: int = 0) -> None:
        """Nodes before their first Setup.

        Args:
            run: name of the run.
            robots: their numbers, from 1.
            pid: of their process, for their statuses.
        """
        robots = list(robots)
        self.nodes = {robot: AgentNode(run, robot, pid=pid, phase=at / len(robots)) for at, robot in enumerate(robots)}
        self._here = {topics.plan(run, robot) for robot in robots}
        """Keys of the plans that are made here."""
        self._hearers: dict[str, set[int]] = {}
        """Robots here that hear the plans of a key."""
        self._waiting: dict[int, list[Incoming]] = {robot: [] for robot in robots}
        """By robot, what it has not been fed yet."""
        self._ask_at = 0.0
        self._actions: list[Action] = []

    @property
    def patience(self) -> float:
        """Feed it again after this long [s], if nothing arrives before."""
        return min(node.patience for node in self.nodes.values())

    @property
    def enough(self) -> int:
        """It need not be woken for fewer plans."""
        return min(node.enough for node in self.nodes.values())

    def feed(self, arrivals: Iterable[Incoming], now: float) -> list[Action]:
        """Take what has arrived.

        Args:
            arrivals: oldest first.
            now: monotonic time [s].

        Returns:
            What is to be done, in order.
        """
        arrivals = list(arrivals)
        for item in arrivals:
            robots: Collection[int] = self.nodes
            if isinstance(item, Sample) and not item.key.endswith("/tick"):
                robots = self._hearers.get(item.key, ())
            if robots:
                read = _read(item)
                for robot in robots:
                    self._waiting[robot].append(read)
        due = [robot for robot, node in self.nodes.items() if self._waiting[robot] or node.patience == 0.0]
        for robot in due if arrivals or due else self.nodes:
            self._feed(robot, now)
        while blocked := [robot for robot in self.nodes if self._waiting[robot] and self._lacks(robot)]:
            for robot in blocked:
                self._feed(robot, now)
        actions, self._actions = self._actions, []
        return actions

    def _lacks(self, robot: int) -> bool:
        return self.nodes[robot].state is State.BLOCKED

    def _feed(self, robot: int, now: float) -> None:
        waiting, self._waiting[robot] = self._waiting[robot], []
        for action in self.nodes[robot].feed(waiting, now):
            self._take(robot, action, now)

    def _take(self, robot: int, action: Action, now: float) -> None:
        """Do what can be done here; the rest is the process's."""
        match action:
            case Publish(key, Plan() as plan):
                for hearer in self._hearers.get(key, ()):
                    self._waiting[hearer].append(Read(key, plan))
            case Subscribe(key):
                hearers = self._hearers.setdefault(key, set())
                hearers.add(robot)
                if key in self._here or len(hearers) > 1:
                    return
            case Unsubscribe(key):
                self._hearers[key].discard(robot)
                if key in self._here or self._hearers[key]:
                    return
            case Announce(key, reliable):
                action = Announce(key, reliable, packed=True)  # what all of them say at a tick goes out at once
            case Ask():
                if now < self._ask_at:
                    return  # the answer to another one is for all
                self._ask_at = now + ASK_SECONDS
        self._actions.append(action)


def _read(item: Incoming) -> Incoming:
    """The item decoded; as it is if it cannot be, for every node counts what it rejects."""
    try:
        match item:
            case Sample(key, payload):
                return Read(key, decode(Tick if key.endswith("/tick") else Plan, payload))
            case Response(_, payload):
                return Read("setup", decode(Setup, payload))
    except WireError:
        pass
    return item
