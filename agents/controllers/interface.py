"""The interface of a controller: its observation at a planning tick, and its solution."""

from dataclasses import dataclass
from typing import Protocol, TypeVar

from formation.arrays import FloatArray
from formation.scenario.controllers import ControllerOptions
from formation.scenario.scenario import Scenario
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
    """The own pose of robot i at tick k, and its estimate of the upstream neighbour."""

    k: int
    pose: FloatArray
    """(3,) [m, m, rad]."""
    upstream: NeighborEstimate


@dataclass(frozen=True, slots=True, eq=False)
class Solution:
    """A controller's result."""

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


Options = TypeVar("Options", bound=ControllerOptions)


def options_of(scenario: Scenario, kind: type[Options]) -> Options:
    """The scenario's options of this controller; the default ones if it names another controller."""
    own = scenario.controller
    return own if isinstance(own, kind) else kind.model_validate({})
