"""The ghost's episode, without any I/O: the live scenario again, under a controller of one's choice.

What a link does to a message is drawn from (seed, link, sequence number) alone, and noise from the seed alone; so it is
enough to have the same tables of faults, and the same orders of a driver, at the same ticks.
"""

from collections import deque
from collections.abc import Iterable, Mapping

from agents.sending import Answer
from formation.arrays import FloatArray
from formation.faults import Fault
from formation.link_ids import LinkId
from formation.paths.driven import Driven
from formation.scenario.scenario import Scenario
from network.messages import WORLD, Ghost
from network.values import Intervention
from runtime.inprocess import Simulation
from world.run_control import with_controller
from world.world import World


class Shadow:
    """One episode beside the live one. It never runs ahead of the orders that are known."""

    def __init__(self, scenario: Scenario, controller: str, episode: int) -> None:
        """A ghost at the start of the episode.

        Args:
            scenario: of the live run.
            controller: of the ghost; if the live run has this controller, with the live one's options too.
            episode: number of the live episode.
        """
        same = controller == scenario.controller.name
        self.controller, self.episode = controller, episode
        self.tables_known = self.drives_known = self.interventions_known = 0
        """Number of fault tables, of the driver's orders and of interventions that are known."""
        own = without_commands(scenario if same else with_controller(scenario, controller))
        self._simulation = Simulation(own, endless=True)
        self._interval = scenario.control_interval
        self._tables: deque[tuple[float, Mapping[LinkId, Fault]]] = deque()
        self._drives: deque[tuple[int, float, float]] = deque()
        self._interventions: deque[Intervention] = deque()
        self._resumed: list[int] = []
        self.answers: dict[int, Answer] = {}
        """Of the agents to the last tick."""

    @property
    def world(self) -> World:
        """Its world."""
        return self._simulation.world

    @property
    def k(self) -> int:
        """Ticks simulated."""
        return self._simulation.world.k

    @property
    def now(self) -> float:
        """Simulated time [s]."""
        return self._simulation.world.now

    @property
    def poses(self) -> FloatArray:
        """True poses (n, 3) [m, m, rad]."""
        return self._simulation.world.plant.poses

    @property
    def finished(self) -> bool:
        """Whether the scenario's duration is over, where the path is not closed."""
        return self._simulation.finished

    def learn(
        self,
        tables: Iterable[tuple[float, Mapping[LinkId, Fault]]],
        drives: Iterable[tuple[int, float, float]] = (),
        interventions: Iterable[Intervention] = (),
    ) -> None:
        """Add what comes next in the live episode.

        Args:
            tables: of faults, each with the time from which on it holds [s].
            drives: orders of the driver: tick from which on it counts, v [m/s], omega [rad/s].
            interventions: what users did to the robots.
        """
        for table in tables:
            self._tables.append(table)
            self.tables_known += 1
        for drive in drives:
            self._drives.append(drive)
            self.drives_known += 1
        for intervention in interventions:
            self._interventions.append(intervention)
            self.interventions_known += 1

    def resume_at(self, ticks: Iterable[int]) -> None:
        """At these ticks, in order, the live world went on from a saved state: here too every agent begins anew."""
        self._resumed = [tick for tick in ticks if tick >= self.k]

    def tick_at(self, stamp: float) -> int:
        """Number of the tick with this stamp [s]."""
        return round(stamp / self._interval)

    def begin_tick(self) -> None:
        """Carry out what is ordered for the tick that comes next; `step` does it too."""
        world = self._simulation.world
        while self._resumed and self._resumed[0] <= world.k:
            del self._resumed[0]
            self._simulation.go_on()
        while self._tables and self._tables[0][0] <= world.now + 1e-9:
            world.impose_faults(self._tables.popleft()[1])
        while world.driver and self._drives and self._drives[0][0] <= world.k:
            world.driver.impose(world.k, *self._drives.popleft()[1:])
        while self._interventions and self._interventions[0].tick <= world.k:
            world.repeat(self._interventions.popleft())

    def step(self) -> None:
        """Simulate one tick."""
        self.begin_tick()
        self.answers = self._simulation.step()

    def hear_statuses(self) -> None:
        """The world hears what its agents know of their links, as at the end of an episode."""
        world = self._simulation.world
        for agent in self._simulation.agents.values():
            world.hear(agent.status(max(0, world.k - 1), world.now))

    def message(self, seq: int) -> Ghost:
        """The Ghost message of now."""
        state = self._simulation.world.state(seq=seq, status="running")
        return Ghost(
            sender=WORLD,
            seq=seq,
            stamp=state.stamp,
            episode=self.episode,
            controller=self.controller,
            poses=state.poses,
            distance_errors=state.distance_errors,
            angle_errors=state.angle_errors,
            tracking_error=state.tracking_error,
        )


def without_commands(scenario: Scenario) -> Scenario:
    """The scenario without the orders that it gives by itself: they are among those of the live episode."""
    if not isinstance(scenario.path, Driven):
        return scenario
    return scenario.model_copy(update={"path": scenario.path.model_copy(update={"commands": ()})})
