"""What a controller is given at a planning tick, what it returns, and the interface between them."""

from dataclasses import dataclass
from typing import Protocol

from formation.arrays import FloatArray
from network.messages import Plan


@dataclass(frozen=True, slots=True, eq=False)
class NeighborEstimate:
    """The neighbour as a controller sees it at one tick."""

    pose: FloatArray
    """(3,) [m, m, rad]."""
    inputs: FloatArray
    """(N, 2) from now on [m/s, rad/s]."""
    plan: Plan | None
    """The message behind it; None before the first."""


@dataclass(frozen=True, slots=True, eq=False)
class Observation:
    """Where robot i stands, at tick k, beside what it believes of its upstream neighbour."""

    k: int
    pose: FloatArray
    """(3,) [m, m, rad]."""
    upstream: NeighborEstimate


@dataclass(frozen=True, slots=True, eq=False)
class Solution:
    """What a controller decided."""

    inputs: FloatArray
    """(N, 2) inputs over the horizon [m/s, rad/s]."""
    converged: bool = True
    """False if the solver failed and the inputs are a fallback."""
    lag: float = 0.0
    lag_rate: float = 0.0
    """As in network.messages.Plan."""


class Controller(Protocol):
    """Plans for one robot. It may remember its last plan; it reads no clock."""

    def plan(self, situation: Observation) -> Solution:
        """Inputs from now on."""
        ...
