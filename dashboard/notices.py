"""Notices: agents and links lost and found, and refused requests. Each stands in the status line for a while."""

from collections.abc import Callable
from typing import NamedTuple

from dashboard.telemetry.links import LinkView
from dashboard.telemetry.snapshot import Snapshot
from formation.link_ids import LinkId

COLOURS = {"info": "ok", "warning": "warn", "error": "bad"}
AT_ONCE = 4
"""More than so many links lost at once are one notice."""


class Notice(NamedTuple):
    """A line about a change."""

    title: str
    text: str
    colour: str
    """Name of the colour of the title: ok, warn or bad."""


Show = Callable[[int | None, Notice], None]
"""(page or None for all, notice): shows it."""
Notify = Callable[[int | None, str, str], None]
"""(page or None for all, title, text): shows a notice, such as why a request was refused."""


class Notices:
    """Turns events of the world, and changes of the links' health, into notices."""

    def __init__(self, show: Show) -> None:
        self._show = show
        self._episode = -1
        self._newest: int | None = None
        self._lost: set[LinkId] = set()
        self._world_alive = True

    def notify(self, page: int | None, title: str, text: str, colour: str = "bad") -> None:
        """Show a notice on one page, or on all."""
        self._show(page, Notice(title, text, colour))

    def update(self, snapshot: Snapshot, links: list[LinkView]) -> None:
        """Show what has changed since the last call."""
        self._world(snapshot)
        state = snapshot.state
        if state is None:
            return
        newest = max((event.number for event in state.events), default=0)
        if self._newest is not None and newest < self._newest:
            self._newest = newest  # another world process, which numbers events from 1
        for event in state.events:
            if self._newest is not None and event.number > self._newest and event.kind in ("agent", "watchdog"):
                self.notify(None, event.text.capitalize(), f"at {event.stamp:.1f} s", COLOURS[event.severity])
        self._newest = newest
        self._links(state.episode, links)

    def _world(self, snapshot: Snapshot) -> None:
        if snapshot.state is None or snapshot.world_alive == self._world_alive:
            return
        self._world_alive = snapshot.world_alive
        if snapshot.world_alive:
            self.notify(None, "The world is back", "The page shows the present again.", "ok")
        else:
            self.notify(None, "The world publishes nothing", "The page shows its last state and waits.")

    def _links(self, episode: int, links: list[LinkView]) -> None:
        # A link that is lost or cut stands in the status line as long as it is; its return is a notice.
        # One that is lost because its receiver has no agent is none: the agent's own event is one.
        lost = {link.id: link for link in links if link.lost and (not link.deaf or link.id in self._lost)}
        if episode == self._episode:
            worse = [lost[link] for link in sorted(lost.keys() - self._lost)]
            if len(worse) > AT_ONCE:
                self.notify(None, f"{len(worse)} links lost", "Robots plan with the last plans they received.")
            if self._lost and not lost:
                self.notify(None, "All links are back", "Every robot receives its neighbour's plans again.", "ok")
        self._episode, self._lost = episode, set(lost)
