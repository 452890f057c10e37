"""What the world needs of the robots' bodies, whatever moves them."""

from collections.abc import Collection, Sequence
from typing import Protocol, runtime_checkable

from formation.arrays import FloatArray
from formation.disturbances import Disturbance
from world.bodies.sensors import Measured


class Bodies(Protocol):
    """The bodies of all robots of an episode. The same scenario gives the same motion for the same inputs."""

    @property
    def poses(self) -> FloatArray:
        """(n, 3) true poses now, read-only [m, m, rad]."""
        ...

    @property
    def odometry(self) -> FloatArray:
        """(n, 2) speeds of the wheels over the last tick [m/s, rad/s]."""
        ...

    def measure(self) -> Measured | None:
        """What sensors deliver at this tick; called once per tick."""
        ...

    def move(self, inputs: FloatArray) -> None:
        """One tick on, under inputs (n, 2) that are kept within the limits [m/s, rad/s]."""
        ...


@runtime_checkable
class Disturbed(Protocol):
    """Bodies that users can push."""

    def disturb(self, disturbances: Sequence[Disturbance]) -> None:
        """These disturbances count from the next tick on, and no others."""
        ...


@runtime_checkable
class Seeing(Protocol):
    """Bodies whose robots may see their upstream neighbour."""

    def close_over(self, away: Collection[int]) -> None:
        """From now on the neighbours are those in the ring of the robots that are not away."""
        ...
