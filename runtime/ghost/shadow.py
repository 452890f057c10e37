"""The ghost's flight, without any I/O: what is flown live, again, under a controller of one's choice.

What a link does to a message is drawn from (seed, link, sequence number) alone, and noise from the seed alone; so it is
enough to have the same tables of faults at the same ticks to meet identical faults.
"""

from collections import deque
from collections.abc import Iterable, Mapping

from formation.faults import Fault
from formation.scenario.scenario import Scenario
from network.messages import WORLD, Ghost
from runtime.inprocess import Simulation
from world.run_control import with_controller


class Shadow:
    """One flight beside the live one. It never goes where the live one's faults are not known yet."""

    def __init__(self, scenario: Scenario, controller: str, episode: int) -> None:
        """At the start of the flight.

        Args:
            scenario: what is flown live.
            controller: whose flight this is; the live one's own, if it has this name, down to its weights.
            episode: number of the live flight.
        """
        same = controller == scenario.controller.name
        self.controller, self.episode = controller, episode
        self.known = 0
        """Tables of faults that are known."""
        self._flight = Simulation(scenario if same else with_controller(scenario, controller), endless=True)
        self._interval = scenario.control_interval
        self._tables: deque[tuple[float, Mapping[str, Fault]]] = deque()

    @property
    def k(self) -> int:
        """Ticks flown."""
        return self._flight.world.k

    @property
    def now(self) -> float:
        """Simulated time [s]."""
        return self._flight.world.now

    @property
    def finished(self) -> bool:
        """Whether the scenario's duration is over, where the path is not closed."""
        return self._flight.finished

    def learn(self, tables: Iterable[tuple[float, Mapping[str, Fault]]]) -> None:
        """The next tables of faults of the live flight, each with the time from which on it holds [s]."""
        for entry in tables:
            self._tables.append(entry)
            self.known += 1

    def tick_at(self, stamp: float) -> int:
        """Number of the tick with this stamp [s]."""
        return round(stamp / self._interval)

    def step(self) -> None:
        """One tick on."""
        world = self._flight.world
        while self._tables and self._tables[0][0] <= world.now + 1e-9:
            world.impose_faults(self._tables.popleft()[1])
        self._flight.step()

    def message(self, seq: int) -> Ghost:
        """Where it is now."""
        state = self._flight.world.state(seq=seq, status="running")
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
