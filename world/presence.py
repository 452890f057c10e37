"""Which agents take part: agents, and the router between them and the world, may join, die, hang and return.

An agent is gone when its liveliness token is. If the router goes, every token does: then, and after the world itself
has stood still, tokens that are missing are waited for. All times are the world's own running time [s].
"""

from enum import StrEnum

from formation.errors import EchelonError
from world.world import World

SUSPECT_SECONDS = 0.05
"""Time from an agent's disappearance to its loss [s]; if the router died, all disappear within some milliseconds."""
RETURN_SECONDS = 3.0
"""Longest wait for the agents after the router came back, or after the world stood still [s]."""
NOTED_SECONDS = 1.0
"""A standstill of the world is an event if it lasts this long [s]; tokens live that long without a sign."""


class Agent(StrEnum):
    """What the world knows of an agent. PRESENT and MISSING agents of the scenario are the live ones."""

    ABSENT = "no token, not live"
    PRESENT = "token, live: it is waited for"
    MISSING = "no token, live: a moment later it is lost, unless it was the router that disappeared"
    FAILED = "token, not live: it did not answer within the patience"


class Change(StrEnum):
    """What changes that."""

    APPEARS = "its token appears"
    DISAPPEARS = "its token disappears"
    LOST = "it has been missing for long enough"
    SILENT = "it did not answer within the patience"
    SPEAKS = "it answers a tick again"
    RECALLED = "a new episode begins"


TABLE: dict[tuple[Agent, Change], Agent] = {
    (Agent.ABSENT, Change.APPEARS): Agent.PRESENT,
    (Agent.PRESENT, Change.DISAPPEARS): Agent.MISSING,
    (Agent.PRESENT, Change.SILENT): Agent.FAILED,
    (Agent.MISSING, Change.APPEARS): Agent.PRESENT,
    (Agent.MISSING, Change.LOST): Agent.ABSENT,
    (Agent.MISSING, Change.SILENT): Agent.ABSENT,
    (Agent.FAILED, Change.APPEARS): Agent.PRESENT,
    (Agent.FAILED, Change.SPEAKS): Agent.PRESENT,
    (Agent.FAILED, Change.RECALLED): Agent.PRESENT,
    (Agent.FAILED, Change.DISAPPEARS): Agent.ABSENT,
}
"""(state, change) -> next state; every other change leaves the state as it is."""


class AgentPresence:
    """Keeps the world's `live` agents in step with their presence on the network."""

    def __init__(self, world: World) -> None:
        self._world = world
        self._agents: dict[int, Agent] = {}
        self._suspects: dict[int, float] = {}
        """When a robot's token has been missing for long enough."""
        self._sessions: dict[int, str] = {}
        """Of each agent's process, as far as it is known."""
        self._lost: set[int] = set()
        """Robots that were live and are not, or whose agent is another now; since `take_lost`."""
        self._connected = True
        self._doubt: tuple[float, float] | None = None
        """While tokens may be missing because of the network: when this ends at the earliest and at the latest.

        In between it ends once every live agent has a token.
        """
        self._dismissed: set[int] = set()
        self._returning: set[int] = set()
        self.launcher = False
        """Whether there is a launcher, which ends and starts processes."""
        self.keepers: set[int] = set()
        """Numbers of the processes that end and start agents where there is no launcher."""

    @property
    def dismissed(self) -> list[int]:
        """Robots whose agents the launcher keeps down."""
        return sorted(self._dismissed & set(self._world.robots))

    def dismiss(self, robot: int, *, for_good: bool) -> None:
        """Have the launcher end an agent.

        Args:
            robot: whose agent.
            for_good: whether it stays down until `readmit`; else the launcher restarts it at once.

        Raises:
            EchelonError: there is no such robot, or no launcher.
        """
        self._check(robot)
        if for_good:
            self._returning.discard(robot)
        elif self._has_token(robot):
            self._returning.add(robot)
        else:  # the launcher restarts it anyway
            return
        self._dismissed.add(robot)

    def readmit(self, robot: int) -> bool:
        """Have the launcher start an agent again; whether it was kept down. Raises EchelonError like `dismiss`."""
        self._check(robot)
        kept = robot in self._dismissed - self._returning
        if kept:
            self._dismissed.discard(robot)
        return kept

    def _check(self, robot: int) -> None:
        if robot not in self._world.robots:
            raise EchelonError(f"expected a robot of the scenario, 1 to {self._world.scenario.size}; got {robot}")
        if not self.keepers:
            self.check_launcher("agents", "End and start their processes as you started them")

    def check_launcher(self, what: str, advice: str) -> None:
        """Refuse what a launcher does if there is none. Raises EchelonError."""
        if not self.launcher:
            raise EchelonError(
                f"nobody here can end or start {what}: this run was not started by `echelon up`. {advice}"
            )

    @property
    def missing(self) -> list[int]:
        """Robots of the scenario without a live agent."""
        return sorted(set(self._world.robots) - self._world.live)

    @property
    def failed(self) -> list[int]:
        """Robots whose agents have a token, but did not answer within the patience."""
        return [robot for robot in self._world.robots if self._agents.get(robot) is Agent.FAILED]

    @property
    def certain(self) -> bool:
        """Whether an agent that is missing or silent is so by itself, not because of the network."""
        return self._doubt is None

    def _has_token(self, robot: int) -> bool:
        return self._agents.get(robot) in (Agent.PRESENT, Agent.FAILED)

    # ------------------------------------------------------------------ what happens

    def go_on(self) -> None:
        """Another process has known these agents: they are live, and their tokens are waited for."""
        self._world.live -= self._dismissed
        self._agents = dict.fromkeys(self._world.live, Agent.MISSING)
        self._suspects = dict.fromkeys(self._world.live, 0.0)
        self._doubt = 0.0, RETURN_SECONDS
        self._connected, self.launcher = True, False
        self._sessions.clear()
        self._lost.clear()
        self.keepers.clear()

    def appear(self, robot: int, session: str = "") -> None:
        """An agent's token has appeared; that of another process than before says that this one is lost."""
        if self._sessions.get(robot, session) != session:
            self._change(robot, Change.DISAPPEARS)
            self._lose(robot)
        self._sessions[robot] = session
        self._change(robot, Change.APPEARS)

    def disappear(self, robot: int, now: float) -> None:
        """An agent's token has disappeared; `settle` decides a moment later."""
        if self._has_token(robot):
            self._change(robot, Change.DISAPPEARS)
            self._suspects[robot] = now + SUSPECT_SECONDS

    def speaks(self, robot: int) -> None:
        """An agent answers, perhaps after it had failed."""
        self._change(robot, Change.SPEAKS)

    def silent(self, robot: int) -> None:
        """An agent did not answer within the patience."""
        self._change(robot, Change.SILENT, "does not answer")

    def recall(self) -> None:
        """A new episode begins: agents that did not answer are given another chance."""
        for robot in list(self._agents):
            self._change(robot, Change.RECALLED)
        live = {robot for robot, agent in self._agents.items() if agent in (Agent.PRESENT, Agent.MISSING)}
        self._world.live = live & set(self._world.robots)

    def connection(self, now: float, *, up: bool) -> None:
        """The link to the router went down or came up."""
        if up == self._connected:
            return
        self._connected = up
        earliest = now if self._doubt is None else max(now, self._doubt[0])
        self._doubt = earliest, now + RETURN_SECONDS
        text, severity = ("router is back", "info") if up else ("router lost: holding", "warning")
        self._world.event("run", text, severity)

    def stood_still(self, now: float, seconds: float) -> None:
        """The world itself, and perhaps everybody, did not run for some time [s]."""
        self._doubt = now + RETURN_SECONDS, now + RETURN_SECONDS  # tokens disappear only after it
        if seconds >= NOTED_SECONDS:
            self._world.event("run", f"the world stood still for {seconds:.1f} s: going on", "warning")

    def settle(self, now: float) -> None:
        """Count agents that have been missing for long enough as lost."""
        if self._doubt is None and not self._suspects:
            return
        if self._doubt is not None:
            earliest, latest = self._doubt
            back = now >= earliest and all(self._has_token(robot) for robot in self._world.live)
            if not self._connected or not (back or now >= latest):
                return
            self._doubt = None
        for robot in [robot for robot, at in self._suspects.items() if now >= at]:
            if self._has_token(robot):
                del self._suspects[robot]
            else:
                self._lose(robot)

    def take_lost(self) -> set[int]:
        """Robots that were lost since the last call; another agent may have taken one's place already."""
        lost, self._lost = self._lost, set()
        return lost

    def _lose(self, robot: int) -> None:
        self._suspects.pop(robot, None)
        self._change(robot, Change.LOST, "lost")
        if robot in self._returning:  # it was to be replaced, and now it is gone
            self._returning.discard(robot)
            self._dismissed.discard(robot)

    def _change(self, robot: int, change: Change, why: str = "") -> None:
        before = self._agents.get(robot, Agent.ABSENT)
        after = self._agents[robot] = TABLE.get((before, change), before)
        world = self._world
        live = after in (Agent.PRESENT, Agent.MISSING)
        if robot not in world.robots or live == (robot in world.live):
            return
        if live:
            world.live.add(robot)
        else:
            world.live.discard(robot)
            self._lost.add(robot)
        text, severity = (f"agent {robot} is here", "info") if live else (f"agent {robot} {why}", "error")
        world.event("agent", text, severity)
