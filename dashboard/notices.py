"""Notices in the corner of the page: agents and links lost and found, and refused requests."""

from collections.abc import Callable

import viser

from dashboard.telemetry.links import LinkView
from dashboard.telemetry.subscriber import Snapshot
from formation.link_ids import LinkId

GOOD, WORSE, BAD, NEUTRAL = (52, 199, 150), (247, 184, 62), (240, 72, 92), (86, 180, 233)
COLOURS = {"info": GOOD, "warning": WORSE, "error": BAD}
AT_ONCE = 4
"""More than so many links lost at once are one notice."""
WELCOME_SECONDS = 20.0

Notify = Callable[[int | None, str, str], None]
"""(page or None for all, title, text): shows a notice, such as why a request was refused."""


class Notices:
    """Turns events of the world, and changes of the links' health, into notices."""

    def __init__(self, server: viser.ViserServer) -> None:
        self._server = server
        self._episode = -1
        self._newest: int | None = None
        self._lost: set[LinkId] = set()
        self._world_alive = True
        server.on_client_connect(_welcome)

    def notify(self, page: int | None, title: str, text: str, colour: tuple[int, int, int] = BAD) -> None:
        """Show a notice on one page, or on all."""
        for number, client in self._server.get_clients().items():
            if page is None or page == number:
                client.add_notification(title, text, color=colour, auto_close_seconds=8.0)

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
            self.notify(None, "The world is back", "The page shows the present again.", GOOD)
        else:
            self.notify(None, "The world publishes nothing", "The page shows its last state and waits.")

    def _links(self, episode: int, links: list[LinkView]) -> None:
        # A link that is lost because its receiver has no agent is no notice: the agent's own event is one.
        lost = {link.id: link for link in links if link.lost and (not link.deaf or link.id in self._lost)}
        if episode == self._episode:
            worse = [lost[link] for link in sorted(lost.keys() - self._lost)]
            if len(worse) > AT_ONCE:
                self.notify(None, f"{len(worse)} links lost", "Robots plan with the last plans they received.")
            else:
                for link in worse:
                    self.notify(
                        None,
                        f"Link {link.sender} → {link.receiver} {link.label.lower()}",
                        f"Robot {link.receiver} uses the last plan it received from robot {link.sender}.",
                    )
            if self._lost and not lost:
                self.notify(None, "All links are back", "Every robot receives its neighbour's plans again.", GOOD)
        self._episode, self._lost = episode, set(lost)


def _welcome(client: viser.ClientHandle) -> None:
    client.add_notification(
        "This is Echelon",
        "The robots keep a formation; each plans for itself with the last plan received from its neighbour. Try: "
        "click a cell of the link matrix or an arrow head, then tick Cut. P pauses, Ctrl-K lists all commands.",
        color=NEUTRAL,
        auto_close_seconds=WELCOME_SECONDS,
    )
