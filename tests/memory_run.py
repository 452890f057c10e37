"""A lockstep run inside one test: the nodes of world and agents on the memory bus, on a time that the test moves on."""

import random
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Any

from agents import process as agent_process
from agents.crew import Crew
from agents.node import AgentNode
from formation.scenario.scenario import Scenario
from network import topics
from network.bus import Publish, Response, perform
from network.codec import decode
from network.control import Operation, request
from network.memory_bus import Letter, MemoryBus, MemoryHub
from network.messages import Command
from network.requests import Reply
from network.throttled_log import ThrottledLog
from world import process as world_process
from world.node import WorldNode
from world.parts import Parts
from world.resume.snapshot import dump, load
from world.world import World

WAY = 0.001
"""Time that a letter takes if nothing happens to it [s]."""
RUN = "memory"


@dataclass(frozen=True)
class Weather:
    """What the bus does to letters while it is bad."""

    seed: int = 0
    lost: float = 0.0
    doubled: float = 0.0
    delayed: float = 0.0
    """Share of the letters, and of the copies, that take up to `longest`: so they come in another order, too."""
    longest: float = 0.0
    """[s]."""
    until: int = 0
    """Number of the letter from which on the weather is fine."""
    letters: Mapping[int, tuple[float, ...]] = field(default_factory=dict)
    """Fates of single letters, by number."""

    def __call__(self, letter: Letter) -> tuple[float, ...]:
        if letter.number in self.letters:
            return self.letters[letter.number]
        if letter.number >= self.until:
            return (WAY,)
        draws = random.Random(f"{self.seed}/{letter.number}")
        if draws.random() < self.lost:
            return ()
        copies = 2 if draws.random() < self.doubled else 1
        return tuple(draws.uniform(0.0, self.longest) if draws.random() < self.delayed else WAY for _ in range(copies))


class _Process:
    """Drains its bus, feeds its node, sends."""

    def __init__(self, bus: MemoryBus) -> None:
        self.bus, self.log = bus, ThrottledLog()
        self.wake_at = 0.0
        self.suspended = False
        self.alive = True


class WorldProcess(_Process):
    def __init__(self, bus: MemoryBus, parts: Parts) -> None:
        super().__init__(bus)
        world_process.join(bus, parts.world.mode)
        self.node = WorldNode(bus.run, parts)

    def turn(self, now: float) -> None:
        perform(self.bus, self.node.feed(self.bus.arrivals(), now), self.log)
        self.wake_at = now + max(self.node.patience(now), WAY)


class AgentProcess(_Process):
    def __init__(self, bus: MemoryBus, robot: int) -> None:
        super().__init__(bus)
        self.robot = robot
        agent_process.join(bus)
        self.node = AgentNode(bus.run, robot)

        self.steps: dict[tuple[int, int], bool] = {}
        """Episodes and ticks that it has answered, and whether it had the upstream plan of the tick before."""

    def turn(self, now: float) -> None:
        actions = self.node.feed(self.bus.arrivals(), now)
        for action in actions:
            if isinstance(action, Publish) and isinstance(action.message, Command):
                k, agent = action.message.seq, self.node._agent
                assert agent is not None
                self.steps.setdefault((action.message.episode, k), agent.heard == k - 1)
        perform(self.bus, actions, self.log)
        self.wake_at = now + self.node.patience


class CrewProcess(_Process):
    def __init__(self, bus: MemoryBus, robots: Sequence[int]) -> None:
        super().__init__(bus)
        agent_process.join(bus)
        self.node = Crew(bus.run, robots)

    def turn(self, now: float) -> None:
        perform(self.bus, self.node.feed(self.bus.arrivals(), now), self.log)
        self.wake_at = now + self.node.patience


class MemoryRun:
    """World and agents as processes without processes; `hub.now` is everybody's clock."""

    def __init__(self, scenario: Scenario, weather: Weather | None = None, *, crew: Sequence[int] = ()) -> None:
        """A run at its start; the agents of a crew share a process."""
        self.hub = MemoryHub(weather or Weather())
        self.world = World(scenario, episode=12345)
        self.counted: list[set[int]] = []
        """Per tick of the episode: the robots whose commands counted."""
        self._start_world(Parts.of(self.world, speed=0.0, start=True))
        self.agents: dict[int, AgentProcess] = {}
        self._crew = {robot: process for process in self._shared(crew) for robot in crew}
        for robot in self.world.robots:
            if robot not in self._crew:
                self.start_agent(robot)
        self.user = self.hub.join(RUN, "user")
        self.dead: list[AgentProcess] = []
        self._outages = 0

    def _shared(self, crew: Sequence[int]) -> list[CrewProcess]:
        return [CrewProcess(self.hub.join(RUN, "crew"), crew)] if crew else []

    def _record(self, world: World) -> None:
        advance = world.advance

        def recorded(commands: Mapping[int, Command]) -> None:
            del self.counted[world.k :]
            self.counted.append(set(commands))
            advance(commands)

        world.advance = recorded  # type: ignore[method-assign]

    # ------------------------------------------------------------------ what may happen

    @property
    def node(self) -> WorldNode:
        return self._world_process.node

    def save_world(self) -> None:
        """Keep the state that another world may go on from."""
        del self.world.advance  # the recorder of this test's
        self._saved = dump(self.node.parts)
        self._record(self.world)

    def replace_world(self, absence: float) -> None:
        """The world is killed, and another goes on from the state that was saved last, after so long [s]."""
        self._world_process.bus.close()
        self._world_process.alive = False

        def start() -> None:
            parts = load(self._saved).parts
            assert self.world.trace is not None
            assert parts.world.trace is not None
            parts.world.trace.refill(self.world.trace.rows(0).ravel(), parts.world.k)
            parts.go_on()
            self._start_world(parts)

        self.at(absence, start)

    def _start_world(self, parts: Parts) -> None:
        self.world = parts.world
        self._saved = dump(parts)
        self._record(self.world)
        self._world_process = WorldProcess(self.hub.join(RUN, "world"), parts)

    def start_agent(self, robot: int) -> None:
        self.agents[robot] = AgentProcess(self.hub.join(RUN, f"agent {robot}"), robot)

    def kill_agent(self, robot: int) -> None:
        process = self.agents[robot]
        if process.alive:
            process.alive = False
            process.bus.close()
            self.dead.append(process)

    def router_goes(self) -> None:
        """Every link goes down, and stays so until the router is back."""
        self._outages += 1
        self.hub.disconnect()

    def router_returns(self, delays: Sequence[float]) -> None:
        """Every process finds the router again in its own time, unless it has gone again."""
        self._outages -= 1
        for bus, delay in zip(list(self.hub.buses), delays, strict=False):
            self.at(delay, partial(self.connect, bus))

    def connect(self, bus: MemoryBus) -> None:
        """A process finds the router, if it is there."""
        if not self._outages:
            self.hub.connect(bus)

    def suspend(self, *robots: int, world: bool = False) -> None:
        for process in self._named(robots, world):
            process.suspended = True

    def resume(self, *robots: int, world: bool = False) -> None:
        for process in self._named(robots, world):
            process.suspended = False
            process.wake_at = self.hub.now

    def _named(self, robots: tuple[int, ...], world: bool) -> list[_Process]:
        named = dict.fromkeys(self._crew.get(robot) or self.agents[robot] for robot in robots)
        return [*named, *([self._world_process] if world else [])]

    def ask(self, operation: Operation) -> None:
        """Have a user request something; the answer is in `replies`."""
        self.user.request(request(operation))

    def ask_until(self, operation: Operation, done: Callable[[], bool]) -> None:
        """Have a user request something, again and again until it is so."""
        for _ in range(20):
            self.ask(operation)
            self.run(5.0, done)
            if done():
                return
        raise AssertionError(f"{operation} was asked for in vain; {self.node.phase}")

    @property
    def replies(self) -> list[Reply]:
        return [decode(Reply, item.payload) for item in self.user.arrivals() if isinstance(item, Response)]

    def forge_tick(self, message: Any) -> None:
        """A stranger publishes a tick."""
        stranger = self.hub.join(RUN, "stranger")
        stranger.announce(topics.tick(RUN))
        stranger.publish(topics.tick(RUN), message)

    # ------------------------------------------------------------------ time

    def at(self, delay: float, act: Callable[[], object]) -> None:
        """Have something happen after so long [s]."""
        self.hub.later(delay, act)

    def run(self, seconds: float, until: Callable[[], bool] = lambda: False) -> None:
        """Go on for so long [s], or until something is so."""
        end = self.hub.now + seconds
        while self.hub.now < end and not until():
            if not self._turns():
                wakes = [process.wake_at for process in self._processes if not process.suspended]
                self.hub.advance(min(end, max(min([self.hub.next_due, *wakes]), self.hub.now)))

    def finish(self, seconds: float = 600.0) -> str:
        """On until the episode is over; its hash. Fails if it is not over after so long [s]."""
        self.run(seconds, lambda: self.finished)
        assert self.finished, f"still {self.node.phase} at tick {self.world.k}; live: {self.world.live}"
        return str(self.world.summary()["trajectory_sha256"])

    @property
    def finished(self) -> bool:
        return self.world.finished

    @property
    def _processes(self) -> list[WorldProcess | AgentProcess | CrewProcess]:
        crew = dict.fromkeys(self._crew.values())
        every: list[WorldProcess | AgentProcess | CrewProcess] = [self._world_process, *self.agents.values(), *crew]
        return [process for process in every if process.alive]

    def _turns(self) -> bool:
        turned = False
        for process in self._processes:
            if not process.suspended and (
                process.bus.inbox.ready(process.node.enough) or self.hub.now >= process.wake_at
            ):
                process.turn(self.hub.now)
                turned = True
        return turned
