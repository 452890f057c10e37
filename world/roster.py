"""Which agents are there: they come, die, hang, and come back, and so does the router between them and the world."""

from time import monotonic

from network.session import Session
from world.world import World

SUSPECT_SECONDS = 0.05
"""From an agent's disappearance to the verdict: if the router died, all disappear within some milliseconds."""
RETURN_SECONDS = 3.0
"""How long agents are waited for after the router came back."""


class Roster:
    """Keeps the world's `live` agents in step with their presence on the network."""

    def __init__(self, session: Session, world: World) -> None:
        self._session, self._world = session, world
        self._present: set[int] = set()
        self._suspects: dict[int, float] = {}
        self._router_lost: float | None = None

    @property
    def missing(self) -> list[int]:
        """Robots of the scenario without a live agent."""
        return sorted(set(self._world.robots) - self._world.live)

    def appear(self, robot: int) -> None:
        """An agent's token is there."""
        self._present.add(robot)
        self.gain(robot)

    def disappear(self, robot: int) -> None:
        """An agent's token is gone; `settle` decides a moment later."""
        self._present.discard(robot)
        self._suspects[robot] = monotonic() + SUSPECT_SECONDS

    def settle(self) -> None:
        """Agents that have been gone for a moment are lost, unless it was the router that has gone."""
        now = monotonic()
        for robot in [robot for robot, at in self._suspects.items() if now >= at]:
            del self._suspects[robot]
            if robot not in self._present and self.reachable():
                self.lose(robot, "lost")

    def gain(self, robot: int) -> None:
        """An agent is there, or answers again."""
        world = self._world
        if robot in world.robots and robot not in world.live and robot in self._present:
            world.live.add(robot)
            world.event("agent", f"agent {robot} is here")

    def lose(self, robot: int, why: str) -> None:
        """The run goes on without an agent."""
        if robot in self._world.live:
            self._world.live.discard(robot)
            self._world.event("agent", f"agent {robot} {why}")

    def recall(self) -> None:
        """Another scenario begins: who is there is in."""
        self._world.live = self._present & set(self._world.robots)

    def reachable(self) -> bool:
        """Whether the router is there, and agents had time to come back if it was not."""
        now, world = monotonic(), self._world
        if not self._session.connected:
            if self._router_lost is None:
                world.event("run", "router lost: holding")
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
