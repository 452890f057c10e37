"""Requests to the world: one thread sends them, so that no button waits and requests keep their order."""

import threading
from queue import Empty
from time import monotonic
from typing import Any

from dashboard.notices import Notify
from dashboard.telemetry.feed import Source
from formation.errors import WireError
from network.bus import Bus
from network.control import Clear, Operation, SetFault
from network.inbox import Inbox
from network.throttled_log import ThrottledLog

QUIET_SECONDS = 0.08
"""A slider that is dragged sends many values; the last one is requested once it has rested for so long [s]."""
SETTLED_SECONDS = 0.4
"""A control of which every value would be an order of its own is left in peace for so long first [s]."""
MOST_WAITING = 200
"""Requests that wait; more are refused."""
POLL_SECONDS = 0.04
"""Between two checks of the resting values and of the scenario [s]."""

NO_RUN = ("This is a record", "What was done in it cannot be changed")
"""Notice for a request where there is no run."""


class RequestQueue:
    """Sends users' requests in their order, and notifies a page if its request was refused."""

    def __init__(self, bus: Bus | None, telemetry: Source, notify: Notify) -> None:
        self._bus, self._telemetry, self._notify = bus, telemetry, notify
        self._queue: Inbox[tuple[Operation, int | None] | None] = Inbox()
        """What is sent, and for which page; None wakes the thread for a resting value."""
        self._lock = threading.Lock()
        self._resting: dict[tuple[str, ...], dict[str, Any]] = {}
        """Changes by links, of sliders that have not rested yet."""
        self._rest: tuple[float, float | None, int | None] = (0.0, None, None)
        """When they are sent, for how long the change holds [s], and the page."""
        self._steering: tuple[Operation, int | None] | None = None
        """The newest order that is not sent yet, and the page; an older one is of no use."""
        self._settling: dict[str, tuple[float, Operation, int | None]] = {}
        """By control: when its newest value is sent, as what, and the page."""
        self._errors = ThrottledLog()
        self._over = False
        self._thread = threading.Thread(target=self._work, name="requests", daemon=True)

    @property
    def possible(self) -> bool:
        """Whether there is a world to send to: a record has none."""
        return self._bus is not None

    def start(self) -> None:
        """Begin to send."""
        self._thread.start()

    def stop(self) -> None:
        """Send no more."""
        self._over = True
        self._thread.join(1.0)

    def refuse(self, title: str, text: str, page: int | None) -> None:
        """Notify a page that its request is not sent."""
        self._notify(page, title, text)

    def ask(self, operation: Operation, page: int | None) -> None:
        """Request an operation, after all earlier requests."""
        if len(self._queue) > MOST_WAITING:
            self.refuse("Not done", "Too many requests are waiting.", page)
            return
        self._flush()
        self._queue.put((operation, page))

    def steer(self, operation: Operation, page: int | None) -> None:
        """Request an order to the formation; it replaces one that is not sent yet."""
        with self._lock:
            waits, self._steering = self._steering is not None, (operation, page)
        if not waits:
            self._queue.put(None)

    def settle(self, control: str, operation: Operation, page: int | None) -> None:
        """Request an operation once no other has come from this control for SETTLED_SECONDS."""
        with self._lock:
            self._settling[control] = (monotonic() + SETTLED_SECONDS, operation, page)

    def _send_settled(self) -> None:
        with self._lock:
            due = [control for control, (at, _, _) in self._settling.items() if at <= monotonic()]
            settled = [self._settling.pop(control)[1:] for control in due]
        for operation, page in settled:
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
        """Change keys of some links' faults.

        Args:
            links: their names; "all" for all links of the ring.
            changes: key and new value of formation.faults.Fault.
            seconds: simulated time after which the change ends; None: never.
            page: that asks.
            at_once: do not wait until the value rests.
        """
        with self._lock:
            self._resting.setdefault(links, {}).update(changes)
            self._rest = (monotonic() + QUIET_SECONDS * (not at_once), seconds, page)
        self._queue.put(None)

    def clear(self, links: tuple[str, ...], page: int | None) -> None:
        """Remove the faults of some links."""
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
            except Exception:  # without this thread no button would work any more
                self._errors.add_exception("asking the world")

    def _next(self) -> None:
        self._send_settled()
        left = self._rest[0] - monotonic() if self._resting else POLL_SECONDS
        if left <= 0.0:
            self._flush()
        try:
            asked = self._queue.get(timeout=min(max(left, 0.0), POLL_SECONDS))
        except Empty:
            self._telemetry.update_scenario()
            return
        if asked is None:
            with self._lock:
                asked, self._steering = self._steering, None
        if asked is None:
            return
        operation, page = asked
        refusal = self._do(operation)
        if refusal is not None:
            self._notify(page, *refusal)

    def _do(self, operation: Operation) -> tuple[str, str] | None:
        """Send a request; returns title and text of a notice if it was not done."""
        if self._bus is None:
            return NO_RUN
        try:
            reply = self._bus.ask(operation)
            if reply is None and not self._bus.connected:  # then None comes at once
                return "The network is gone", "The run's router cannot be reached, so the request was not sent."
        except WireError as error:
            return "The world's reply is not valid", str(error)
        except Exception as error:  # a session that is being closed, say
            self._errors.add_exception("asking the world")
            return "The request could not be sent", (str(error) or type(error).__name__).splitlines()[0][:200]
        if reply is None:
            return "No answer", "The world did not answer; is it still running?"
        return None if reply.ok else ("Not done", reply.reason)


def _given(link: str, changes: dict[str, Any], seconds: float | None) -> dict[str, Any]:
    """Fields of a SetFault; not validated here, because the world validates what a page sends."""
    fields: dict[str, Any] = {"link": link, "changes": changes}
    return fields if seconds is None else {**fields, "seconds": seconds}
