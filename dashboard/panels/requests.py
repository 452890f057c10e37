"""Where requests to the world are made: one thread asks, so that no button ever waits and requests keep their order."""

import threading
from collections.abc import Callable
from queue import Empty, SimpleQueue
from time import monotonic
from typing import Any

from dashboard.telemetry.subscriber import TelemetrySubscriber
from formation.errors import WireError
from network.control import Clear, Operation, SetFault
from network.throttled_log import ThrottledLog
from network.zenoh_bus import Session

QUIET_SECONDS = 0.08
"""A slider that is dragged says many values; the one on which it rests is sent."""
POLL_SECONDS = 0.04

Notify = Callable[[int | None, str, str], None]
"""(page or None for all, title, text): shows a person why something was not done."""


class RequestQueue:
    """Takes what people ask for, in order, and tells them if it was refused."""

    def __init__(self, session: Session, telemetry: TelemetrySubscriber, notify: Notify) -> None:
        self._session, self._telemetry, self._notify = session, telemetry, notify
        self._queue: SimpleQueue[tuple[Operation, int | None] | None] = SimpleQueue()  # None wakes
        self._lock = threading.Lock()
        self._resting: dict[tuple[str, ...], dict[str, Any]] = {}
        self._rest: tuple[float, float | None, int | None] = (0.0, None, None)
        self._errors = ThrottledLog()
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

    def change(
        self,
        links: tuple[str, ...],
        changes: dict[str, Any],
        seconds: float | None,
        page: int | None,
        *,
        at_once: bool = False,
    ) -> None:
        """Change keys of the faults of some links, at once or when the person's hand has come to rest."""
        with self._lock:
            self._resting.setdefault(links, {}).update(changes)
            self._rest = (monotonic() + QUIET_SECONDS * (not at_once), seconds, page)
        self._queue.put(None)

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
            try:
                self._next()
            except Exception:  # without this thread no button would do anything any more
                self._errors.add_exception("asking the world")

    def _next(self) -> None:
        left = self._rest[0] - monotonic() if self._resting else POLL_SECONDS
        if left <= 0.0:
            self._flush()
        try:
            asked = self._queue.get(timeout=min(max(left, 0.0), POLL_SECONDS))
        except Empty:
            self._telemetry.update_scenario()
            return
        if asked is None:
            return
        operation, page = asked
        complaint = self._do(operation)
        if complaint is not None:
            self._notify(page, *complaint)

    def _do(self, operation: Operation) -> tuple[str, str] | None:
        """Ask; title and text of what a person must hear, if anything."""
        try:
            reply = self._session.ask(operation)
            if reply is None and not self._session.connected:  # then nobody is asked, and None comes at once
                return "The network is gone", "The run's router cannot be reached, so nothing was asked of the world."
        except WireError as error:
            return "The world's answer makes no sense", str(error)
        except Exception as error:  # a session that is being closed, say
            self._errors.add_exception("asking the world")
            return "The world could not be asked", (str(error) or type(error).__name__).splitlines()[0][:200]
        if reply is None:
            return "No answer", "The world did not answer; is it still running?"
        return None if reply.ok else ("Not done", reply.reason)


def _given(link: str, changes: dict[str, Any], seconds: float | None) -> dict[str, Any]:
    """Fields of a SetFault; not checked here, because it is the world that judges what a page sends."""
    fields: dict[str, Any] = {"link": link, "changes": changes}
    return fields if seconds is None else {**fields, "seconds": seconds}
