"""Which agents are live: agents, and the router between them and the world, may join, die, hang and return."""

from time import monotonic

from formation.errors import EchelonError
from network.zenoh_bus import ZenohBus
from world.world import World

SUSPECT_SECONDS = 0.05
"""Time from an agent's disappearance to its loss [s]; if the router died, all disappear within some milliseconds."""
RETURN_SECONDS = 3.0
"""Longest wait for the agents after the router came back [s]."""


class AgentPresence:
    """Keeps the world's `live` agents in step with their presence on the network."""

    def __init__(self, session: ZenohBus, world: World) -> None:
        self._session, self._world = session, world
        self._present: set[int] = set()
        self._suspects: dict[int, float] = {}
        self._router_lost: float | None = None
        self._dismissed: set[int] = set()
        self._returning: set[int] = set()
        self.launcher = False
        """Whether there is a launcher, which ends and starts agents."""

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
        elif robot in self._present:
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
        if not self.launcher:
            raise EchelonError(
                "nobody here can end or start agents: this run was not started by `echelon up`. "
                f"With compose: docker compose kill agent-{robot}, and docker compose start agent-{robot}"
            )

    @property
    def missing(self) -> list[int]:
        """Robots of the scenario without a live agent."""
        return sorted(set(self._world.robots) - self._world.live)

    def appear(self, robot: int) -> None:
        """An agent's token has appeared."""
        self._present.add(robot)
        self.gain(robot)

    def disappear(self, robot: int) -> None:
        """An agent's token has disappeared; `settle` decides a moment later."""
        self._present.discard(robot)
        self._suspects[robot] = monotonic() + SUSPECT_SECONDS

    def settle(self) -> None:
        """Count agents that disappeared a moment ago as lost, unless it was the router that disappeared."""
        now = monotonic()
        for robot in [robot for robot, at in self._suspects.items() if now >= at]:
            del self._suspects[robot]
            if robot not in self._present and self.reachable():
                self.lose(robot, "lost")
                if robot in self._returning:  # it was to be replaced, and now it is gone
                    self._returning.discard(robot)
                    self._dismissed.discard(robot)

    def gain(self, robot: int) -> None:
        """Count an agent as live: it has joined, or answers again."""
        world = self._world
        if robot in world.robots and robot not in world.live and robot in self._present:
            world.live.add(robot)
            world.event("agent", f"agent {robot} is here")

    def lose(self, robot: int, why: str) -> None:
        """Continue the run without an agent."""
        if robot in self._world.live:
            self._world.live.discard(robot)
            self._world.event("agent", f"agent {robot} {why}", "error")

    def recall(self) -> None:
        """Another scenario begins: every agent with a token is live."""
        self._world.live = self._present & set(self._world.robots)

    def reachable(self) -> bool:
        """Whether the router is reachable, and the agents had time to reconnect after an outage."""
        now, world = monotonic(), self._world
        if not self._session.connected:
            if self._router_lost is None:
                world.event("run", "router lost: holding", "warning")
            self._router_lost = now
            return False
        if self._router_lost is None:
            return True
        if not (world.live <= self._present or now - self._router_lost > RETURN_SECONDS):
            return False
        self._router_lost = None
        world.event("run", "router is back")
        for robot in sorted(world.live - self._present):
            self.lose(robot, "lost")
        return True
