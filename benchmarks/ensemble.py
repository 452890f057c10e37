"""A world with its agents in its own process: what the page of a large formation receives, on a machine with few cores.

python -m benchmarks.ensemble --run NAME --connect ENDPOINT --scenario NAME [--set KEY=VALUE] [--endless]

It is the world of any run (world/process.py), but its ticks are answered at once, here. Statuses go out over Zenoh as
those of separate processes would; plans and commands do not.
"""

import argparse
import sys
from time import monotonic

from agents.agent import Agent
from agents.node import STATUS_INTERVAL
from agents.sending import Answer
from formation.pattern import downstream
from formation.scenario.files import load
from formation.scenario.overrides import from_json
from network import topics
from network.bus import Presence, Sample
from network.codec import encode
from network.lifetime import Lifetime
from network.messages import Message, Tick
from network.zenoh_bus import ZenohBus
from world.parts import Parts
from world.process import run
from world.world import World


class Ensemble(ZenohBus):
    """The world's place on the network, with every agent behind it."""

    def __init__(self, endpoint: str, run: str) -> None:
        super().__init__(endpoint, run)
        self.world: World | None = None
        self._agents: dict[int, Agent] = {}
        self._announced: set[int] = set()
        self._setup: tuple[int, int] | None = None
        self._before: dict[int, Answer] = {}
        self._answered = -1
        self._status_due = 0.0

    def gather(self, world: World) -> None:
        """Every agent of the world's scenario is here."""
        self.world = world
        for robot in set(world.robots) - self._announced:
            self._announced.add(robot)
            self.announce(topics.status(self.run, robot))
            self.appear("agent", robot)
            self.inbox.put(Presence("agent", robot, True, self.session))

    def publish(self, key: str, message: Message) -> None:
        """A tick is answered at once."""
        super().publish(key, message)
        if isinstance(message, Tick):
            self._answer(message)

    def _answer(self, tick: Tick) -> None:
        world = self.world
        assert world is not None
        if self._setup == (tick.episode, tick.revision) and tick.seq == self._answered:
            return  # repeated
        self._answered = tick.seq
        if self._setup is None or self._setup[0] != tick.episode:
            self.gather(world)
            self._agents = {robot: Agent(world.scenario, robot, episode=tick.episode) for robot in world.robots}
            self._before = {}
        if self._setup != (tick.episode, tick.revision):
            self._setup = tick.episode, tick.revision
            for agent in self._agents.values():
                agent.set_faults(world.faults.table)
        for robot, answer in self._before.items():
            if answer.plan is not None:
                self._agents[downstream(robot, len(self._agents))].receive(answer.plan)
        for robot, agent in self._agents.items():
            self._before[robot] = answer = agent.step(tick)
            self.inbox.put(Sample(topics.command(self.run, robot), encode(answer.command)))
        if monotonic() >= self._status_due:
            self._status_due = monotonic() + STATUS_INTERVAL
            for robot, agent in self._agents.items():
                super().publish(topics.status(self.run, robot), agent.status(tick.seq, tick.stamp))


def main() -> int:
    """Run until the process is asked to end."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--run", required=True)
    parser.add_argument("--connect", required=True)
    parser.add_argument("--scenario", required=True)
    parser.add_argument("--overrides", default="{}", metavar="JSON")
    parser.add_argument("--endless", action="store_true")
    options = parser.parse_args()
    scenario = load(options.scenario, from_json(options.overrides))
    with Ensemble(options.connect, options.run) as session:
        world = World(scenario, endless=options.endless)
        session.gather(world)
        run(session, Parts.of(world, speed=1.0, start=True), Lifetime(session.wake))
    return 0


if __name__ == "__main__":
    sys.exit(main())
