"""What recorders get of a world: it is collected while a recorder is there, and costs next to nothing otherwise."""

from collections.abc import Iterable
from itertools import takewhile

import numpy as np

from formation.arrays import FloatArray
from network.messages import WORLD
from network.stretch import Kind, Order, Stretch
from network.values import Excursion
from world.bodies.own import user_code_of
from world.world import World

STRETCH_SECONDS = 0.05
"""Simulated time from one Stretch to the next [s]."""


class Journal:
    """Ticks, orders and events of a world that have not been handed over yet."""

    def __init__(self, world: World, *, wanted: bool = False) -> None:
        """Nothing collected yet.

        Args:
            world: of which.
            wanted: whether there is a recorder.
        """
        self._world, self._wanted = world, wanted
        self._begin()

    def _begin(self) -> None:
        """An episode begins."""
        self._episode = self._world.episode
        self._orders: list[Order] = []
        self._tables = self._drives = self._interventions = self._over = 0
        self._answering = set(self._world.robots)
        self._events = 0
        self._open()

    def _open(self) -> None:
        """A recorder has nothing of the episode yet."""
        self._stretches = self._sent = 0
        self._rows: list[tuple[FloatArray, FloatArray]] = []
        if self._wanted:
            self._add()

    def go_on(self) -> None:
        """Another process has handed over what there was: a recorder gets this segment as it gets an episode."""
        self._episode, self._wanted, self._events = self._world.episode, False, 0
        self._open()

    @property
    def wanted(self) -> bool:
        """Whether there is a recorder."""
        return self._wanted

    @wanted.setter
    def wanted(self, wanted: bool) -> None:
        if wanted != self._wanted:
            self._wanted, self._events = wanted, 0
            self._open()
            text, severity = ("is recorded", "info") if wanted else ("is no longer recorded", "warning")
            self._world.event("run", text, severity)

    def note(self, answered: Iterable[int]) -> None:
        """The world has moved on by a tick, with the commands of these robots."""
        world = self._world
        self._look()
        robots = set(answered)
        if robots != self._answering and world.mode == "lockstep":
            self._answering = robots
            self._order(world.k - 1, "agents", {"answered": sorted(robots)})
        self._note_orders()
        if self._wanted:
            self._add()

    def _note_orders(self) -> None:
        """What users and the schedule have ordered since the last look."""
        world = self._world
        while self._tables < world.faults.changes:
            for stamp, table in world.faults.since(self._tables):
                self._tables += 1
                tick = round(stamp / world.scenario.control_interval)
                self._order(tick, "faults", {str(link): fault.plain() for link, fault in table.items()})
        while world.driver and self._drives < world.driver.count:
            for tick, order in world.driver.since(self._drives):
                self._drives += 1
                self._order(tick, "drive", {"v": order.v, "omega": order.omega})
        while self._interventions < world.interventions.count:
            for done in world.interventions.since(self._interventions):
                self._interventions += 1
                self._order(done.tick, done.kind, done.value)

    def _look(self) -> None:
        if self._episode != self._world.episode:
            self._begin()

    def _add(self) -> None:
        if not self._rows:
            self._first = self._world.k
        self._rows.append((self._world.plant.poses.copy(), self._world.inputs))

    def _order(self, tick: int, kind: Kind, value: dict[str, object]) -> None:
        self._orders.append(Order(len(self._orders), tick, kind, value))

    def _excursions(self) -> list[Excursion]:
        """Those that have ended since the last look."""
        ledger = self._world.ledger
        found, self._over = ledger.over_since(self._over), ledger.over
        return [*found, *ledger.going_on] if self._world.finished else found

    def take(self, *, all_of_it: bool = False) -> Stretch | None:
        """What has been collected, once it is enough for a message, or `all_of_it`; None if there is nothing."""
        world, interval = self._world, self._world.scenario.control_interval
        self._look()
        enough = len(self._rows) * interval >= STRETCH_SECONDS - 1e-9 or world.finished or not self._stretches
        if not self._rows or not (enough or all_of_it):
            return None
        poses, inputs = (np.concatenate(column) for column in zip(*self._rows, strict=True))
        block = world.reference.block(world.k)
        row = world.k - block.first
        newest = list(takewhile(lambda event: event.number > self._events, reversed(world.events)))[::-1]
        stretch = Stretch(
            sender=WORLD,
            seq=self._stretches,
            stamp=world.now,
            episode=world.episode,
            first=self._first,
            poses=poses,
            inputs=inputs,
            slots=block.slots[row],
            centre=block.centre[row, :3],
            mode=world.mode,
            orders=self._orders[self._sent :],
            events=newest,
            excursions=self._excursions(),
            scenario="" if self._stretches else world.given.model_dump_json(exclude_unset=True),
            resumed=[] if self._stretches else self._world.resumed,
            user_code=[] if self._stretches else user_code_of(world.scenario),
        )
        self._stretches, self._sent, self._rows = self._stretches + 1, len(self._orders), []
        self._events = newest[-1].number if newest else self._events
        return stretch
