"""What a controller is given at a planning tick, what it returns, and the interface between them."""

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from agents.belief import Upstream
from formation.arrays import FloatArray
from formation.pattern import upstream
from formation.reference import Block, Reference
from formation.scenario import Scenario


@dataclass(frozen=True, slots=True, eq=False)
class Situation:
    """Where robot i stands, at tick k, beside what it believes of its upstream neighbour."""

    k: int
    pose: FloatArray
    """(3,) [m, m, rad]."""
    upstream: Upstream


@dataclass(frozen=True, slots=True, eq=False)
class Solution:
    """What a controller decided."""

    inputs: FloatArray
    """(N, 2) inputs over the horizon [m/s, rad/s]."""
    converged: bool = True
    """False if the solver failed and the inputs are a fallback."""


class Controller(Protocol):
    """Plans for one robot. It may remember its last plan; it reads no clock."""

    def plan(self, situation: Situation) -> Solution:
        """Inputs from now on."""
        ...


class Pair:
    """The task of one robot and its upstream neighbour: references by tick, and the pattern between them."""

    def __init__(self, scenario: Scenario, robot: int) -> None:
        controller = scenario.controller
        self.reference: Reference = scenario.reference([robot, upstream(robot, scenario.size)])
        self.horizon, self.stride = controller.horizon, scenario.stride
        self.tick, self.interval = scenario.control_interval, controller.prediction_interval
        self.distance = float(scenario.pattern.distance[robot - 1])
        self.angle = float(scenario.pattern.angle[robot - 1])
        self.centre = scenario.pattern.centre[robot - 1]
        self.offset = scenario.formation.array[robot - 1]
        self.offset_upstream = scenario.formation.array[upstream(robot, scenario.size) - 1]
        self.limits = np.array([scenario.robots.limits.v, scenario.robots.limits.omega])
        self._block: Block | None = None
        self._psi: FloatArray = np.empty(0)

    def block(self, k: int) -> tuple[Block, int]:
        """The reference's block for tick k and the row of k in it. Column 0 is the robot, 1 its neighbour."""
        block = self.reference.block(k)
        if block is not self._block:
            self._block, self._psi = block, block.centre[:, 2] + self.angle
        return block, k - block.first

    @property
    def psi(self) -> FloatArray:
        """psi_r (T,) on the rows of the last block asked for [rad]."""
        return self._psi

    def slot(self, k: int, column: int) -> tuple[FloatArray, FloatArray]:
        """Slot pose (3,) now, and inputs (N, 2) that keep to it over the horizon; column as in `block`."""
        block, row = self.block(k)
        return block.slots[row, column], block.inputs[row : row + self.horizon * self.stride : self.stride, column]
