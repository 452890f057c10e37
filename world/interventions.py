"""What is done to the robots: disturbances of the scenario and of users, and shapes that users ordered."""

import math
from collections import deque
from collections.abc import Iterable
from itertools import islice
from typing import Any

from formation.disturbances import Disturbance
from formation.errors import EchelonError
from formation.formation_spec import Change
from formation.scenario.scenario import Scenario
from formation.schema import next_of
from network.values import Intervention, Pushed
from world.bodies.interface import Bodies, Disturbed

KEPT = 5000
"""Interventions that are kept of an episode, for a ghost that repeats it."""
TOLD = 1000
"""Of these, in one reply."""
MOST = 500
"""Disturbances that may be in force or to come: each costs time at every tick."""


class Interventions:
    """Of one episode: the disturbances in force, and what users did, by tick."""

    def __init__(self, scenario: Scenario, bodies: Bodies) -> None:
        """What the scenario has, and nothing of users.

        Args:
            scenario: of the episode.
            bodies: of its robots; some can be disturbed, with `disturb(disturbances)`.
        """
        self._bodies, self._implementation = bodies, scenario.bodies.implementation
        self._all = scenario.disturbances
        self._seen_late = scenario.nominal.age * scenario.control_interval
        """Localisation is so late [s]: what was blind then still counts."""
        self.acting: tuple[Disturbance, ...] = ()
        """The disturbances that act now."""
        self.due = -math.inf
        """Before this time `update` has nothing to do [s]."""
        self.changes: list[Change] = []
        """Of the shape, by users and with the ring."""
        self.count = 0
        """Interventions in this episode so far."""
        self._history: deque[Intervention] = deque(maxlen=KEPT)

    def push(self, k: int, now: float, disturbance: Disturbance) -> None:
        """Add a disturbance at tick k, `now` [s].

        Raises:
            EchelonError: these bodies know none, or there are too many already.
        """
        if not isinstance(self._bodies, Disturbed):
            raise EchelonError(
                f"expected bodies that can be disturbed; {self._implementation} has no disturb(disturbances)"
            )
        past = now - self._seen_late - 1e-9
        kept = tuple(entry for entry in self._all if entry.until is None or entry.until >= past)
        if len(kept) >= MOST:
            raise EchelonError(f"expected at most {MOST} disturbances at a time; release some first")
        self._set((*kept, disturbance))
        self._note(k, "push", disturbance.model_dump(mode="json", exclude_defaults=True))

    def release(self, k: int, now: float, robot: int | None) -> None:
        """End what acts on a robot, or on all, at tick k, `now` [s]."""
        self._set(tuple(kept for entry in self._all if (kept := _ended(entry, now, robot)) is not None))
        self._note(k, "release", {"robot": robot})

    def reshape(self, k: int, change: Change) -> None:
        """A shape was ordered at tick k."""
        self.close(change)
        self._note(k, "shape", change.model_dump(mode="json", exclude_unset=True))

    def close(self, change: Change) -> None:
        """The ring changed, and the shape with it: whoever repeats the one has the other."""
        self.changes.append(change)

    def ring(self, k: int, away: Iterable[int]) -> None:
        """At tick k the ring was closed over these robots."""
        self._note(k, "ring", {"away": sorted(away)})

    def _set(self, disturbances: tuple[Disturbance, ...]) -> None:
        if isinstance(self._bodies, Disturbed) and disturbances != self._all:
            self._all, self.due = disturbances, -math.inf
            self._bodies.disturb(disturbances)

    def _note(self, k: int, kind: Any, value: dict[str, Any]) -> None:
        self.count += 1
        self._history.append(Intervention(k, kind, value))

    def update(self, now: float) -> list[tuple[str, bool]]:
        """What begins and what ends at `now` [s]: a line each, and whether it begins."""
        if now < self.due:
            return []
        self.due = next_of([time for entry in self._all for time in (entry.at, entry.until)], now)
        before, self.acting = self.acting, tuple(entry for entry in self._all if entry.on(now))
        if before == self.acting:
            return []
        over = [entry for entry in before if not any(_same(entry, other) for other in self.acting)]
        new = [entry for entry in self.acting if not any(_same(entry, other) for other in before)]
        return [
            *((f"robot {entry.robot}: no longer {entry.words}", False) for entry in over),
            *((f"robot {entry.robot}: {entry.words}{_for(entry)}", True) for entry in new),
        ]

    @property
    def shown(self) -> list[Pushed]:
        """What acts now, for displays."""
        return [Pushed(entry.robot, entry.words, entry.until) for entry in self.acting]

    def since(self, known: int) -> list[Intervention]:
        """The interventions of this episode from number `known` on, at most TOLD.

        Raises:
            EchelonError: they are no longer kept.
        """
        forgotten = self.count - len(self._history)
        if known < forgotten:
            raise EchelonError(f"expected at most {KEPT} interventions in an episode; got {self.count}")
        return list(islice(self._history, known - forgotten, known - forgotten + TOLD))


def _ended(entry: Disturbance, now: float, robot: int | None) -> Disturbance | None:
    """The entry as it is once it is released at `now` [s]; None if nothing is left of it."""
    if robot not in (None, entry.robot) or not entry.on(now):
        return entry
    return entry.model_copy(update={"until": now}) if now > entry.at else None


def _same(one: Disturbance, other: Disturbance) -> bool:
    return one is other or one == other


def _for(entry: Disturbance) -> str:
    return "" if entry.until is None else f", for {entry.until - entry.at:.3g} s"
