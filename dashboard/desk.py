"""Where requests to the world are made: one thread asks, so that no button ever waits and requests keep their order."""

import threading
from collections.abc import Callable
from queue import Empty, SimpleQueue
from time import monotonic
from typing import Any

from dashboard.feed import Feed
from formation.errors import WireError
from network.control import Clear, Operation, SetFault
from network.session import Session

QUIET_SECONDS = 0.12
"""A slider that is dragged says many values; the one on which it rests is sent."""
POLL_SECONDS = 0.04

Tell = Callable[[int | None, str, str], None]
"""(page or None for all, title, text): shows a person why something was not done."""


class Desk:
    """Takes what people ask for, in order, and tells them if it was refused."""

    def __init__(self, session: Session, feed: Feed, tell: Tell) -> None:
        self._session, self._feed, self._tell = session, feed, tell
        self._queue: SimpleQueue[tuple[Operation, int | None]] = SimpleQueue()
        self._lock = threading.Lock()
        self._resting: dict[tuple[str, ...], dict[str, Any]] = {}
        self._rest: tuple[float, float | None, int | None] = (0.0, None, None)
        self._over = False
        self._thread = threading.Thread(target=self._work, name="desk", daemon=True)

    def start(self) -> None:
        """Begin to ask."""
        self._thread.start()

    def stop(self) -> None:
        """Ask no more."""
        self._over = True
        self._thread.join(1.0)

    def ask(self, operation: Operation, page: int | None) -> None:
        """Have the world do this, after everything that was asked before."""
        self._flush()
        self._queue.put((operation, page))

    def change(self, links: tuple[str, ...], changes: dict[str, Any], seconds: float | None, page: int | None) -> None:
        """Change keys of the faults of some links, once the person's hand has come to rest."""
        with self._lock:
            self._resting.setdefault(links, {}).update(changes)
            self._rest = (monotonic() + QUIET_SECONDS, seconds, page)

    def clear(self, links: tuple[str, ...], page: int | None) -> None:
        """Take back the faults of some links."""
        for link in links:
            self.ask(Clear(link=link), page)

    def _flush(self) -> None:
        with self._lock:
            resting, self._resting = self._resting, {}
            _, seconds, page = self._rest
        for links, changes in resting.items():
            for link in links:
                self._queue.put((SetFault.model_construct(**_given(link, changes, seconds)), page))

    def _work(self) -> None:
        while not self._over:
            if self._resting and monotonic() >= self._rest[0]:
                self._flush()
            try:
                operation, page = self._queue.get(timeout=POLL_SECONDS)
            except Empty:
                self._feed.learn()
                continue
            self._do(operation, page)

    def _do(self, operation: Operation, page: int | None) -> None:
        try:
            reply = self._session.ask(operation)
        except WireError as error:
            self._tell(page, "The world's answer makes no sense", str(error))
            return
        except Exception as error:  # a session without its router raises zenoh's own errors
            self._tell(page, "The world cannot be reached", str(error).splitlines()[0][:200])
            return
        if reply is None:
            self._tell(page, "No answer", "The world did not answer within two seconds; is it still running?")
        elif not reply.ok:
            self._tell(page, "Not done", reply.reason)


def _given(link: str, changes: dict[str, Any], seconds: float | None) -> dict[str, Any]:
    """Fields of a SetFault; not checked here, because it is the world that judges what a page sends."""
    fields: dict[str, Any] = {"link": link, "changes": changes}
    return fields if seconds is None else {**fields, "seconds": seconds}
