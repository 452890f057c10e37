"""What a person must not miss, said in the corner of the page: lost and found agents, lost links, refused requests."""

import viser

from dashboard.telemetry.links import LinkView
from dashboard.telemetry.subscriber import Snapshot

GOOD, BAD, PLAIN = (52, 199, 150), (240, 72, 92), (86, 180, 233)
AT_ONCE = 4
"""More than so many links in trouble are one notice."""
WELCOME_SECONDS = 20.0


class Notices:
    """Compares what is with what was, and says what changed for the worse or back."""

    def __init__(self, server: viser.ViserServer) -> None:
        self._server = server
        self._epoch = -1
        self._number: int | None = None
        self._lost: set[str] = set()
        self._here = True
        server.on_client_connect(_welcome)

    def notify(self, page: int | None, title: str, text: str, colour: tuple[int, int, int] = BAD) -> None:
        """Say this on one page, or on all."""
        for number, client in self._server.get_clients().items():
            if page is None or page == number:
                client.add_notification(title, text, color=colour, auto_close_seconds=8.0)

    def compare(self, snapshot: Snapshot, links: list[LinkView]) -> None:
        """Say what has changed since the last call."""
        self._world(snapshot)
        state = snapshot.state
        if state is None:
            return
        newest = max((event.number for event in state.events), default=0)
        if self._number is not None and newest < self._number:
            self._number = newest  # another world
        for event in state.events:
            if self._number is not None and event.number > self._number and event.kind in ("agent", "watchdog"):
                good = "here" in event.text or "again" in event.text
                self.notify(None, event.text.capitalize(), f"at {event.stamp:.1f} s", GOOD if good else BAD)
        self._number = newest
        self._links(state.episode, links)

    def _world(self, snapshot: Snapshot) -> None:
        if snapshot.state is None or snapshot.world_alive == self._here:
            return
        self._here = snapshot.world_alive
        if snapshot.world_alive:
            self.notify(None, "The world is back", "What you see is live again.", GOOD)
        else:
            self.notify(None, "The world has gone silent", "Waiting for it; what you see is its last word.")

    def _links(self, episode: int, links: list[LinkView]) -> None:
        now_lost = {link.name for link in links if link.lost and not link.deaf}  # that agent's loss is told anyway
        if episode == self._epoch:
            worse = sorted(now_lost - self._lost)
            words = {link.name: link.label for link in links}
            if len(worse) > AT_ONCE:
                self.notify(None, f"{len(worse)} links lost", "Robots plan with what they last heard.")
            else:
                for name in worse:
                    sender, receiver = name.split("->")
                    self.notify(
                        None,
                        f"Link {sender} → {receiver} {words[name].lower()}",
                        f"Robot {receiver} goes by the last plan it heard from robot {sender}.",
                    )
            if self._lost and not now_lost:
                self.notify(None, "All links are back", "Every robot hears its neighbour again.", GOOD)
        self._epoch, self._lost = episode, now_lost


def _welcome(client: viser.ClientHandle) -> None:
    client.add_notification(
        "This is Echelon",
        "Robots fly a formation; each plans for itself with what its neighbour last told it. Try: press a cell of the "
        "link matrix, or an arrow head, then tick Cut. P pauses, Ctrl-K lists all commands.",
        color=PLAIN,
        auto_close_seconds=WELCOME_SECONDS,
    )
