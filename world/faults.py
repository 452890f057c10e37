"""Which fault is on which link, at which tick: the scenario's own, its schedule, and what people set live."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from formation.faults import PERFECT, Fault, ScheduledFault, links_named, plan_links, with_changes
from formation.scenario import Scenario


@dataclass(slots=True)
class _Override:
    """What a person set on one link."""

    changes: dict[str, Any]
    until: float | None


@dataclass(slots=True)
class FaultState:
    """The faults in force. Later layers win: [link], then the schedule, then what people set."""

    scenario: Scenario
    table: Mapping[str, Fault] = field(default_factory=dict)
    """Every link that is not perfect."""
    _overrides: dict[str, _Override] = field(default_factory=dict)
    _cancelled: set[int] = field(default_factory=set)
    _active: tuple[int, ...] = ()
    _stale: bool = True

    def update(self, now: float) -> list[str]:
        """Bring the table to time `now` [s]. Returns a line per link that changed."""
        for link, override in list(self._overrides.items()):
            if override.until is not None and now >= override.until - 1e-9:
                del self._overrides[link]
                self._stale = True
        active = tuple(i for i, entry in enumerate(self.scenario.faults) if i not in self._cancelled and _on(entry, now))
        if active == self._active and not self._stale:
            return []
        self._active, self._stale = active, False
        base = {} if self.scenario.link == PERFECT else dict.fromkeys(plan_links(self.scenario.size), self.scenario.link)
        table: dict[str, Fault] = dict(base)
        for index in active:
            entry = self.scenario.faults[index]
            for link in links_named(entry.link, self.scenario.size):
                table[link] = with_changes(table.get(link, PERFECT), entry.changes())
        for link, override in self._overrides.items():
            table[link] = with_changes(table.get(link, PERFECT), override.changes)
        table = {link: fault for link, fault in table.items() if fault != PERFECT}
        lines = [
            f"{link}: {table.get(link, PERFECT).words()}"
            for link in sorted({*table, *self.table})
            if table.get(link) != self.table.get(link)
        ]
        self.table = table
        return lines

    def change(self, link: str, changes: Mapping[str, Any], until: float | None) -> None:
        """Set keys of a link's fault (or of the whole ring's, "all") on top of what it has, until a time.

        Raises:
            FaultError: no such link, an unknown key, or a value out of range; then nothing has changed.
        """
        links = links_named(link, self.scenario.size)
        for name in links:
            with_changes(self.table.get(name, PERFECT), changes)
        for name in links:
            before = self._overrides.get(name)
            self._overrides[name] = _Override({**(before.changes if before else {}), **changes}, until)
        self._stale = True

    def clear(self, link: str, now: float) -> None:
        """Take back what people set and end what the schedule has on now; [link] stays.

        Raises:
            FaultError: no such link.
        """
        links = links_named(link, self.scenario.size)
        if link.strip() == "all":
            self._overrides.clear()
        for name in links:
            self._overrides.pop(name, None)
        for index, entry in enumerate(self.scenario.faults):
            if now >= entry.at - 1e-9 and set(links_named(entry.link, self.scenario.size)) <= set(links):
                self._cancelled.add(index)
        self._stale = True

    def restart(self) -> None:
        """Time begins anew: the schedule is whole again; what people set without an end stays."""
        self._cancelled.clear()
        self._overrides = {link: o for link, o in self._overrides.items() if o.until is None}
        self._stale = True


def _on(entry: ScheduledFault, now: float) -> bool:
    return now >= entry.at - 1e-9 and (entry.until is None or now < entry.until - 1e-9)
