"""What the page knows at one moment, of a run or of its past."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from formation.arrays import FloatArray
from formation.pattern import leader
from formation.scenario.scenario import Scenario
from network.messages import Ghost, State, Status


@dataclass(frozen=True, slots=True)
class Snapshot:
    """What the page knows at one moment."""

    state: State | None
    """The newest; None before the first."""
    scenario: Scenario | None
    """The scenario; None until the setup that fits `state` has arrived."""
    statuses: Mapping[int, Status]
    poses: FloatArray
    """(n, 3) true poses, interpolated between the last two states so that motion is smooth [m, m, rad]."""
    stamp: float
    """Simulated time of these poses [s]."""
    ghosts: tuple[Ghost, ...]
    """Ghost messages since the last snapshot, oldest first."""
    world_alive: bool
    """Whether the world has published its state lately."""
    connected: bool
    """Whether the router can be reached."""
    origin: FloatArray = field(default_factory=lambda: np.zeros(2))
    """(2,) of all places here, in the scenario's coordinates [m]."""

    @property
    def leader(self) -> int:
        """The robot that knows the path, where one alone does."""
        if self.state is None or self.scenario is None:
            return 1
        return leader(self.state.away, follows=self.scenario.path.leader == "next")

    @property
    def noise(self) -> float:
        """Standard deviation of x and y as localisation measures them [m]; 0 if it is exact, or not known yet."""
        return 0.0 if self.scenario is None else self.scenario.body.localisation.position
