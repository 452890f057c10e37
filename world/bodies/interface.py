"""What the world needs of the robots' bodies, whatever moves them."""

from typing import Protocol

from formation.arrays import FloatArray


class Bodies(Protocol):
    """The bodies of all robots of an episode. The same scenario gives the same motion for the same inputs."""

    @property
    def poses(self) -> FloatArray:
        """(n, 3) true poses now, read-only [m, m, rad]."""
        ...

    def measure(self) -> FloatArray:
        """Poses (n, 3) as localisation measures them; called once per tick [m, m, rad]."""
        ...

    def move(self, inputs: FloatArray) -> None:
        """One tick on, under inputs (n, 2) that are kept within the limits [m/s, rad/s]."""
        ...
