"""The task of one robot and its upstream neighbour: references by tick, and the pattern between them."""

import math
from collections.abc import Collection
from typing import NamedTuple

import numpy as np

from agents.kernels.unicycle import sample
from agents.kernels.window.filter import Table
from formation.arrays import FloatArray
from formation.pattern import leader, neighbours, rotate
from formation.reference import Block
from formation.scenario.registry import spec_of
from formation.scenario.scenario import Scenario
from formation.way import HeardReference
from network.values import NO_WAY


class HorizonReference(NamedTuple):
    """The reference over one horizon: of robot i, its upstream neighbour, that one's, and the downstream neighbour."""

    slots: FloatArray
    """(N + 1, 4, 3) [m, m, rad]."""
    inputs: FloatArray
    """(N, 4, 2) that keep to the slots [m/s, rad/s]."""

    @property
    def pair(self) -> tuple[FloatArray, FloatArray]:
        """Slots (N + 1, 2, 3) and inputs (N, 2, 2) of robot i and its upstream neighbour, contiguous."""
        return np.ascontiguousarray(self.slots[:, :2]), np.ascontiguousarray(self.inputs[:, :2])


class Task:
    """The task of one robot and its upstream neighbour: references by tick, and the pattern between them."""

    def __init__(self, scenario: Scenario, robot: int, away: Collection[int] = ()) -> None:
        controller = scenario.controller
        self.robot, self.robots = robot, scenario.size
        """Its number, from 1, and how many there are."""
        self.members = scenario.size - len(away)
        """How many of them are in the ring."""
        self.first = leader(away, follows=True)
        """The first of them."""
        other, self.further, after = neighbours(robot, scenario.size, away)
        self._columns = columns = [robot, other, self.further, after]
        self._rounded = rounded = spec_of(controller).rounds_corners
        leads = robot == leader(away, follows=scenario.path.leader == "next")
        knows = scenario.path.known_to == "all" or (leads and not scenario.driven)
        told = None if knows else scenario.heard_reference(columns, away, rounded=rounded)
        self.way: HeardReference | None = told
        """The reference of a robot that is told the path; None if it knows it."""
        self.reference = self.way or scenario.reference(columns, rounded=rounded)
        self._tells = scenario.path.known_to == "leader"
        self.waits_for_lost = scenario.path.wait_for_lost
        """Whether a robot that is lost holds up all others."""
        self.horizon, self.stride = controller.horizon, scenario.stride
        self.tick, self.interval = scenario.control_interval, controller.prediction_interval
        self.limits = np.array([scenario.robots.limits.v, scenario.robots.limits.omega])
        self.every = controller.plan_every
        """Ticks from one plan to the next."""
        self.columns_of_sides = (1, 3)
        """Columns of the upstream and the downstream neighbour."""
        self.first_lost = robot
        """If the robot is lost: the first in the ring that is, as far as it knows."""
        self.lag = 0.0
        """How far the robot's reference time is behind the clock [s]; waiting sets it."""
        self.pace = 1.0
        """At which rate its reference time runs over the horizon."""
        self._table: tuple[Block, Table] | None = None
        self._ahead: tuple[int, float, float, HorizonReference] | None = None

    def reshape(self, scenario: Scenario, k: int) -> None:
        """From tick k on the formation has the offsets of this scenario; before it they are the same."""
        if self.way is not None:
            self.way.reshape(k, scenario.offsets.rows(self._columns))
        else:
            self.reference = scenario.reference(self._columns, rounded=self._rounded)
        self._ahead = self._table = None

    def hear(self, way: FloatArray, k: int, sender: int = 0, lost: int = 0) -> None:
        """A neighbour's preview of the path came in; from tick k on it counts, or from the reference time then.

        Args:
            way: the preview.
            k: when the next command acts.
            sender: the neighbour; 0 for the driver.
            lost: of its plan.
        """
        if sender == self._columns[1]:
            self.first_lost = lost or self.robot
        if self.way is not None and self.way.hear(way, k, self._late, self.first_lost):
            self._ahead = self._table = None

    def preview(self, k: int) -> FloatArray:
        """The preview of the path that a plan of tick k carries, (m, 6) as network.messages.Plan has it."""
        return self.reference.preview(max(k - self._late, 0)) if self._tells else NO_WAY

    @property
    def _late(self) -> int:
        """Ticks of the lag, where the path's reference time is what lost robots are waited for by."""
        return int(self.lag / self.tick) if self.waits_for_lost else 0

    def forget(self) -> None:
        """The robot begins in the middle of an episode: unless it knows the path, it waits for word of it."""
        if self.way is not None:
            self.way.forget()

    @property
    def knows(self) -> bool:
        """Whether it has a reference to follow."""
        return self.way is None or self.way.known

    def way_age(self, k: int) -> float:
        """How old its knowledge of the path is at tick k [s]."""
        return self.way.age(k) if self.way is not None else 0.0

    def lost(self, k: int) -> bool:
        """Whether the robot does not know where the formation is at tick k."""
        return self.way is not None and self.way.lost(k - self._late)

    def block(self, k: int) -> tuple[Block, int]:
        """The reference's block for tick k and the row of k in it. Column 0 is the robot, 1 its neighbour."""
        block = self.reference.block(k)
        return block, k - block.first

    def table(self, k: int) -> Table:
        """The reference around tick k as compiled code takes it."""
        block, known = self.reference.block(k if k > 0 else 0), self._table
        if known is None or known[0] is not block:
            known = self._table = block, Table(block.slots, block.inputs, block.first)
        return known[1]

    def target(self, k: int) -> tuple[FloatArray, float]:
        """The robot's slot (3,) at tick k, a little earlier if between ticks, and that slot's speed at full pace."""
        block, row = self.block(math.floor(self._row(k)))
        return block.slots[row, 0], float(block.inputs[row, 0, 0])

    def ahead(self, k: int) -> HorizonReference:
        """The reference from tick k on, by the robot's reference time."""
        known = self._ahead
        if known is not None and known[0] == k and known[1] == self.lag and known[2] == self.pace:
            return known[3]
        block, row = self.begin(k)
        slots, inputs = np.empty((self.horizon + 1, 4, 3)), np.empty((self.horizon, 4, 2))
        sample(block.slots, block.inputs, row, self.stride, self.pace, slots, inputs)
        ahead = HorizonReference(slots, inputs)
        self._ahead = k, self.lag, self.pace, ahead
        return ahead

    def begin(self, k: int) -> tuple[Block, float]:
        """The reference's block in which the horizon from tick k on begins, by the robot's reference time; the row."""
        if self.lag == 0.0 and self.pace <= 1.0:
            block = self.reference.block(k)
            return block, float(k - block.first)
        at = k - self.lag / self.tick
        if self.way is not None and self.pace > 1.0:
            self.way.block(math.ceil(at + (self.pace - 1.0) * self.horizon * self.stride))
        whole = math.floor(at)
        block = self.reference.block(whole)
        return block, whole - block.first + (at - whole)

    def slot(self, k: int, column: int) -> tuple[FloatArray, FloatArray]:
        """Slot pose (3,) now, and inputs (N, 2) that keep to it over the horizon; column as in `block`."""
        ahead = self.ahead(k)
        return ahead.slots[0, column], ahead.inputs[:, column]

    def offsets(self, k: int) -> FloatArray:
        """Where both slots are in the frame of the path at tick k, by the clock: (2, 2) [m]."""
        block, row = self.block(k)
        return rotate(-block.centre[row, 2], block.slots[row, :2, :2] - block.centre[row, :2])

    def _row(self, k: int) -> float:
        return k - self.lag / self.tick
