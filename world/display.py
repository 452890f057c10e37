"""What displays get of a world: its State, twenty times a second and at once after what users ask."""

from collections.abc import Iterable

from network import topics
from network.messages import State
from world.presence import AgentPresence
from world.rate import Rate
from world.run_control import RunControl
from world.states import SKIPPED
from world.world import World

STATE_INTERVAL = topics.STATE.interval
"""Between two states [s]."""


class Display:
    """The states that have been sent, and when the next one is due."""

    def __init__(self, world: World, rate: Rate, presence: AgentPresence, control: RunControl) -> None:
        self._world, self._rate, self._presence, self._control = world, rate, presence, control
        self._count, self._at = 0, 0.0

    def hurry(self) -> None:
        """Something has changed: the next state is due now."""
        self._at = 0.0

    def go_on(self) -> None:
        """Another process may have sent states since this was saved."""
        self._count += SKIPPED
        self._at = 0.0

    def due(self, now: float) -> bool:
        """Whether it is time for a state; `now` is monotonic time [s]."""
        return now >= self._at

    def state(self, now: float, silent: Iterable[int]) -> State:
        """The State of now.

        Args:
            now: monotonic time [s].
            silent: robots whose agents do not answer.
        """
        self._at = now + STATE_INTERVAL
        self._count += 1
        return self._world.state(
            seq=self._count,
            status=self._control.status,
            speed=self._rate.speed,
            pace=self._rate.measured(self._world.now, now),
            overruns=self._rate.overruns,
            rejected=self._control.rejected,
            waiting_for=sorted({*self._presence.missing, *silent}),
            dismissed=self._presence.dismissed,
            compare=self._control.compare,
            record=self._control.record,
            recording=self._control.recording,
        )
