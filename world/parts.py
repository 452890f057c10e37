"""What a world's process holds of a run: another process that takes over needs all of it, and nothing else."""

from typing import NamedTuple, Self

from world.display import Display
from world.journal import Journal
from world.presence import AgentPresence
from world.rate import Rate
from world.run_control import RunControl
from world.world import World


class Parts(NamedTuple):
    """They refer to each other."""

    world: World
    rate: Rate
    presence: AgentPresence
    control: RunControl
    journal: Journal
    display: Display

    @classmethod
    def of(cls, world: World, *, speed: float, start: bool) -> Self:
        """Of a run that begins.

        Args:
            world: what is simulated.
            speed: simulated seconds per second; 0 means as fast as possible.
            start: begin as soon as every agent is there.
        """
        rate, presence = Rate(speed), AgentPresence(world)
        control = RunControl(world, rate, presence, go=start)
        return cls(world, rate, presence, control, Journal(world), Display(world, rate, presence, control))

    def go_on(self) -> None:
        """These were saved by another process, which is gone: begin a segment of the episode.

        Whatever that process has published since then is not known here, so nothing is numbered as it may have been.
        """
        self.world.go_on()
        self.presence.go_on()
        self.journal.go_on()
        self.display.go_on()
