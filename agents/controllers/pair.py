"""The task of one robot and its upstream neighbour: references by tick, and the pattern between them."""

import math
from dataclasses import dataclass

import numpy as np

from agents.kernels.unicycle import sample
from formation.arrays import FloatArray
from formation.pattern import rotate, upstream
from formation.reference import Block, Reference
from formation.scenario.registry import spec_of
from formation.scenario.scenario import Scenario


@dataclass(frozen=True, slots=True, eq=False)
class HorizonReference:
    """The reference of a pair over one horizon; robot i is row 0, its upstream neighbour row 1."""

    slots: FloatArray
    """(N + 1, 2, 3) [m, m, rad]."""
    inputs: FloatArray
    """(N, 2, 2) that keep to the slots [m/s, rad/s]."""


class Pair:
    """The task of one robot and its upstream neighbour: references by tick, and the pattern between them."""

    def __init__(self, scenario: Scenario, robot: int) -> None:
        controller = scenario.controller
        other = upstream(robot, scenario.size)
        self.reference: Reference = scenario.reference([robot, other], rounded=spec_of(controller).rounds_corners)
        self.horizon, self.stride = controller.horizon, scenario.stride
        self.tick, self.interval = scenario.control_interval, controller.prediction_interval
        self.limits = np.array([scenario.robots.limits.v, scenario.robots.limits.omega])
        self.lag = 0.0
        """How far the robot's reference time is behind the clock [s] (agents/controllers/progress.py)."""
        self.pace = 1.0
        """At which rate its reference time runs over the horizon."""
        self._ahead: tuple[tuple[int, float, float], HorizonReference] | None = None

    def block(self, k: int) -> tuple[Block, int]:
        """The reference's block for tick k and the row of k in it. Column 0 is the robot, 1 its neighbour."""
        block = self.reference.block(k)
        return block, k - block.first

    def target(self, k: int) -> tuple[FloatArray, float]:
        """The robot's slot (3,) at tick k, a little earlier if between ticks, and that slot's speed at full pace."""
        block, row = self.block(math.floor(self._row(k)))
        return block.slots[row, 0], float(block.inputs[row, 0, 0])

    def ahead(self, k: int) -> HorizonReference:
        """The reference from tick k on, by the robot's reference time."""
        key = (k, self.lag, self.pace)
        if self._ahead is None or self._ahead[0] != key:
            at = self._row(k)
            block, row = self.block(math.floor(at))
            slots, inputs = np.empty((self.horizon + 1, 2, 3)), np.empty((self.horizon, 2, 2))
            between = row + (at - math.floor(at))
            sample(block.slots, block.inputs, between, self.stride, self.pace, slots, inputs)
            self._ahead = key, HorizonReference(slots, inputs)
        return self._ahead[1]

    def slot(self, k: int, column: int) -> tuple[FloatArray, FloatArray]:
        """Slot pose (3,) now, and inputs (N, 2) that keep to it over the horizon; column as in `block`."""
        ahead = self.ahead(k)
        return ahead.slots[0, column], ahead.inputs[:, column]

    def offsets(self, k: int) -> FloatArray:
        """Where both slots are in the frame of the path at tick k, by the clock: (2, 2) [m]."""
        block, row = self.block(k)
        return rotate(-block.centre[row, 2], block.slots[row, :, :2] - block.centre[row, :2])

    def _row(self, k: int) -> float:
        return k - self.lag / self.tick
