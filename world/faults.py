"""The fault of every link at every tick: the scenario's own, its schedule, and what users set live."""

import math
from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass, field
from itertools import islice
from typing import Any

from formation.errors import EchelonError, FaultError
from formation.faults import PERFECT, Fault, ScheduledFault, with_changes
from formation.link_ids import LinkId, every_link, links_named, plan_links
from formation.scenario.scenario import Scenario
from formation.schema import next_of, time_of

KEPT_CHANGES = 5000
"""Fault tables that are kept of an episode, for a ghost that repeats it."""
TOLD_CHANGES = 25
"""Tables in one reply, at most ..."""
TOLD_FAULTS = 8192
"""... and faults in them, unless there is one table: it fits into a message even if all links have every key set."""


@dataclass(frozen=True, slots=True)
class _Wish:
    """A fault that a user set on one link."""

    link: LinkId
    changes: dict[str, Any]
    until: float | None
    """Simulated time at which it ends [s]; None for never."""


@dataclass(slots=True)
class FaultState:
    """The faults in force. Later layers win: [link], then the schedule, then what users set, in that order."""

    scenario: Scenario
    table: Mapping[LinkId, Fault] = field(default_factory=dict)
    """Every link that is not perfect."""
    _wishes: list[_Wish] = field(default_factory=list)
    _cancelled: set[tuple[int, LinkId]] = field(default_factory=set)
    """Scheduled faults (by index) that users ended on a link."""
    _active: tuple[int, ...] | None = None
    """Scheduled faults that the table was computed from; None if it must be computed anew."""
    due: float = -math.inf
    """Before this time `update` has nothing to do [s]."""
    _imposed: Mapping[LinkId, Fault] | None = None
    """In a world that repeats another's faults: their table."""
    away: frozenset[int] = frozenset()
    """Robots over which the ring is closed."""
    changes: int = 0
    """Number of tables in this episode so far."""
    _history: deque[tuple[float, Mapping[LinkId, Fault]]] = field(default_factory=lambda: deque(maxlen=KEPT_CHANGES))

    def update(self, now: float) -> list[tuple[LinkId, Fault]]:
        """Update the table to time `now` [s]. Returns the links that changed, with what they have now."""
        if now < self.due:
            return []
        ends = [*(entry.at for entry in self.scenario.faults), *(entry.until for entry in self.scenario.faults)]
        self.due = next_of([*ends, *(wish.until for wish in self._wishes)], now)
        wishes = [wish for wish in self._wishes if wish.until is None or now < wish.until - 1e-9]
        active = tuple(i for i, entry in enumerate(self.scenario.faults) if _on(entry, now))
        if active == self._active and len(wishes) == len(self._wishes):
            return []
        self._active, self._wishes = active, wishes
        before, self.table = self.table, self._made_of(active) if self._imposed is None else self._imposed
        if self.table != before or not self.changes:
            self.changes += 1
            self._history.append((now, self.table))
        return [
            (link, self.table.get(link, PERFECT))
            for link in sorted({*self.table, *before})
            if self.table.get(link) != before.get(link)
        ]

    @property
    def _both(self) -> bool:
        """Whether plans also go upstream."""
        return self.scenario.controller.uses_downstream

    def _named(self, link: str) -> list[LinkId]:
        scenario = self.scenario
        return links_named(link, scenario.size, both=self._both, driven=scenario.driven, away=self.away)

    def close_over(self, away: frozenset[int]) -> None:
        """From the next update on the ring is closed over these robots."""
        self.away = away
        self._compute_anew()

    def _compute_anew(self) -> None:
        """At the next update."""
        self._active, self.due = None, -math.inf

    def _made_of(self, active: tuple[int, ...]) -> dict[LinkId, Fault]:
        size, both = self.scenario.size, self._both
        table = dict.fromkeys(plan_links(size, both=both, away=self.away), self.scenario.link)
        for index in active:
            entry = self.scenario.faults[index]
            for link in self._named(entry.link):
                if (index, link) not in self._cancelled:
                    table[link] = with_changes(table.get(link, PERFECT), entry.changes())
        for wish in self._wishes:
            table[wish.link] = with_changes(table.get(wish.link, PERFECT), wish.changes)
        return {link: fault for link, fault in table.items() if fault != PERFECT}

    def change(self, link: str, changes: Mapping[str, Any], until: float | str | None, now: float) -> None:
        """Set keys of a link's fault (or of the whole ring's, "all") on top of what it has.

        Args:
            link: one, or "all".
            changes: keys of a Fault.
            until: simulated time at which it ends [s], a number or text such as "2s"; None for never.
            now: simulated time [s].

        Raises:
            FaultError: no such link, an unknown key, a value out of range, or an end that is none or not later than
                now; then nothing has changed.
        """
        end = _end(until, now)
        links = self._named(link)
        for name in links:
            with_changes(self.table.get(name, PERFECT), changes)
        self._wishes = [*self._wishes, *(_Wish(name, dict(changes), end) for name in links)]
        self._merge()
        self._compute_anew()

    def _merge(self) -> None:
        """Merge consecutive lasting changes of a link, so that a moved slider does not accumulate them."""
        merged: list[_Wish] = []
        last: dict[LinkId, int] = {}
        for wish in self._wishes:
            at = last.get(wish.link)
            if at is not None and merged[at].until is None and wish.until is None:
                merged[at] = _Wish(wish.link, {**merged[at].changes, **wish.changes}, None)
            else:
                last[wish.link] = len(merged)
                merged.append(wish)
        self._wishes = merged

    def clear(self, link: str, now: float) -> None:
        """Remove what users set on a link, or on every link ("all"), and end the scheduled faults that are active now.

        The scenario's [link] stays.

        Raises:
            FaultError: no such link.
        """
        scenario = self.scenario
        every = every_link(scenario.size, both=self._both, driven=scenario.driven, away=self.away)
        links = every if link.strip() == "all" else self._named(link)
        self._wishes = [wish for wish in self._wishes if wish.link not in links]
        running = [index for index, entry in enumerate(self.scenario.faults) if _on(entry, now)]
        self._cancelled |= {(index, name) for index in running for name in links}
        self._compute_anew()

    def impose(self, table: Mapping[LinkId, Fault]) -> None:
        """Use exactly these faults of another world from now on, whatever is scheduled."""
        self._imposed = table
        self._compute_anew()

    def since(self, known: int) -> list[tuple[float, Mapping[LinkId, Fault]]]:
        """The tables of this episode from number `known` on, as many as have room, each with the time of its start [s].

        Raises:
            FaultError: they are no longer kept.
        """
        forgotten = self.changes - len(self._history)
        if known < forgotten:
            raise FaultError(f"expected at most {KEPT_CHANGES} changes of faults in an episode; got {self.changes}")
        found: list[tuple[float, Mapping[LinkId, Fault]]] = []
        faults = 0
        for at, table in islice(self._history, known - forgotten, known - forgotten + TOLD_CHANGES):
            faults += len(table)
            if found and faults > TOLD_FAULTS:
                break
            found.append((at, table))
        return found

    def restart(self) -> None:
        """Start a new episode: the whole schedule applies again; what users set without an end stays."""
        self._cancelled.clear()
        self._wishes = [wish for wish in self._wishes if wish.until is None]
        self._compute_anew()
        self._history.clear()
        self.changes = 0


def _end(until: float | str | None, now: float) -> float | None:
    """The time at which a fault ends [s], checked. Raises FaultError."""
    if until is None:
        return None
    try:
        end = time_of("until", until)
    except EchelonError as error:
        raise FaultError(str(error)) from None
    if not now < end - 1e-9:
        raise FaultError(f"until: expected a simulated time later than now, {now:g} s; got {end:g}")
    return end


def _on(entry: ScheduledFault, now: float) -> bool:
    return now >= entry.at - 1e-9 and (entry.until is None or now < entry.until - 1e-9)
