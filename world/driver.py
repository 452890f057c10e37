"""Who drives the formation, where its path is driven: orders of the scenario and of users, and the way to a point.

An order counts from the next tick to be computed on. Ten times a second, and when the order changes, the driver sends
robot 1 the order in force and where the centre is by the orders so far; the world's slots follow the same track.
"""

import math
from collections import deque
from itertools import islice
from typing import NamedTuple

import numpy as np

from formation.arrays import FloatArray, frozen
from formation.driving.going import towards
from formation.driving.law import REST, Order
from formation.driving.track import Dated
from formation.errors import EchelonError
from formation.scenario.scenario import Scenario
from network.values import NO_DRIVE, Driving

SAID_AGAIN = 0.1
"""The order in force is sent again after so long, and the way to a point is looked at [s]."""
KEPT_ORDERS = 50_000
"""Orders that are kept of an episode, for a ghost that repeats it."""
TOLD_ORDERS = 2_000
"""Of these, in one reply."""


class Goal(NamedTuple):
    """Where a user wants the centre to be [m]."""

    x: float
    y: float


class Driver:
    """The orders of one episode; `begin` is called once before each tick is computed."""

    def __init__(self, scenario: Scenario, *, forgets: bool) -> None:
        """No order yet.

        Args:
            scenario: whose path is driven.
            forgets: drop where the centre was: the run may go on for ever.
        """
        self._forgets = forgets
        self.reference = scenario.driving()
        """By the orders so far."""
        self.count = 0
        """Orders that changed something in this episode so far."""
        self._law, self._tick = scenario.law, scenario.control_interval
        self._every = max(1, round(SAID_AGAIN / self._tick))
        self._planned = deque(scenario.orders)
        self._order, self._until = REST, math.inf
        self._goal: Goal | None = None
        self._history: deque[Dated] = deque(maxlen=KEPT_ORDERS)
        self._changed = False
        """Whether the order changed at the tick that is computed next."""
        self._sent = 0

    def begin(self, k: int) -> list[str]:
        """Tick k is computed next: give the orders that are due. What is worth a line in the event log."""
        self._changed, lines = False, []
        if self._forgets:
            self.reference.track.forget(k - 1)
        if k >= self._until:
            self._goal, self._until = None, math.inf
            lines += self._give(k, REST, "no order any more: ")
        while self._planned and self._planned[0].tick <= k:
            self._goal, self._until = None, math.inf
            lines += self._give(k, self._planned.popleft().order)
        if self._goal is not None and k % self._every == 0:
            lines += self._go_on(k, self._goal)
        return lines

    def order(self, k: int, v: float, omega: float, seconds: float | None) -> list[str]:
        """An order of a user: v [m/s] and omega [rad/s], for so long [s] or until the next; what is worth a line."""
        self._goal = None
        self._until = math.inf if seconds is None else k + max(1, round(seconds / self._tick))
        return self._give(k, self._law.within(v, omega))

    def go_to(self, k: int, x: float, y: float) -> list[str]:
        """A user wants the centre at (x, y) [m]; what is worth a line in the event log."""
        self._goal, self._until = Goal(x, y), math.inf
        return [f"drives to ({x:.3f}, {y:.3f}) m", *self._go_on(k, self._goal)]

    def reshape(self, k: int, scenario: Scenario) -> None:
        """From tick k on the formation has the offsets of this scenario."""
        self._law = scenario.law
        self.reference.reshape(k, scenario.offsets, self._law)

    def impose(self, k: int, v: float, omega: float) -> None:
        """An order of another world at the same tick."""
        self._give(k, Order(v, omega))

    def _go_on(self, k: int, goal: Goal) -> list[str]:
        order = towards(self._law, self.reference.track.at(k), *goal)
        self._give(k, order or REST)
        if order is not None:
            return []
        self._goal = None
        return [f"arrives at ({goal.x:.3f}, {goal.y:.3f}) m"]

    def _give(self, k: int, order: Order, why: str = "") -> list[str]:
        if order == self._order:
            return []
        self._order = order
        self.reference.order(k, order)
        self.count += 1
        self._history.append(Dated(k, order))
        self._changed = True
        return [f"{why}{order.v:.3g} m/s, {order.omega:.3g} rad/s"]

    @property
    def shown(self) -> Driving:
        """For displays."""
        return Driving(self.count, *self._order, self._goal and (self._goal.x, self._goal.y))

    @property
    def commands(self) -> list[tuple[float, float, float]]:
        """The orders of this episode as a scenario has them, `path.commands`."""
        return [(k * self._tick, *order) for k, order in self._history]

    def since(self, known: int) -> list[Dated]:
        """The orders of this episode from number `known` on, at most TOLD_ORDERS.

        Raises:
            EchelonError: they are no longer kept.
        """
        forgotten = self.count - len(self._history)
        if known < forgotten:
            raise EchelonError(f"expected at most {KEPT_ORDERS} orders in an episode; got {self.count}")
        return list(islice(self._history, known - forgotten, known - forgotten + TOLD_ORDERS))

    def message(self, k: int) -> FloatArray:
        """What robot 1 is sent at tick k, (1, 11) as network.messages.Tick has it; call once a tick."""
        if not self._changed and k % self._every:
            return NO_DRIVE
        self._sent += 1
        return frozen(np.array([[self._sent, k, *self.reference.track.at(k), *self._order]]))
