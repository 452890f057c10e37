"""A process's connection to its run: one Zenoh session, and one inbox for everything that it receives.

All that arrives (samples, queries, processes that come and go) lands in one queue in the order of arrival. Zenoh's
own receive threads only append to it, so a slow reader never stalls the session, and a reader can wait with a time
limit. This is the only module that imports zenoh.
"""

import json
import os
import threading
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from queue import Empty, SimpleQueue
from time import monotonic
from types import TracebackType
from typing import Any, NamedTuple, Self

import zenoh

from formation.errors import EchelonError
from network import topics
from network.codec import decode, encode
from network.control import GetSetup, Operation, request
from network.messages import Message, Reply, Request, Setup

LEASE_MS = 1000
"""Zenoh's lease: a process that sends nothing for this long counts as gone. Each side announces its own."""
CONNECT_MS = 10_000
CLOSE_SECONDS = 2.0
"""Time limit for closing a session [s]; on a dead link it would take ten seconds."""


class Sample(NamedTuple):
    """A payload that was published."""

    key: str
    payload: bytes


@dataclass(frozen=True, slots=True)
class Query:
    """A request that waits for an answer; `answer` may be called from any thread, once."""

    payload: bytes
    answer: Callable[[bytes], None]


@dataclass(frozen=True, slots=True)
class Presence:
    """A process has joined or left."""

    role: str
    number: int
    here: bool


class Wake:
    """An item that wakes the reader of an inbox."""


Incoming = Sample | Query | Presence | Wake


def config(*, endpoint: str, router: bool) -> zenoh.Config:
    """Configuration of a session with the router only: no scouting, no other listeners, no shared memory."""
    settings: dict[str, Any] = {
        "mode": "router" if router else "client",
        "scouting": {"multicast": {"enabled": False}, "gossip": {"enabled": False}, "delay": 1},
        "transport": {"link": {"tx": {"lease": LEASE_MS, "keep_alive": 4}}, "shared_memory": {"enabled": False}},
    }
    if router:
        settings["listen"] = {"endpoints": [endpoint]}
    else:
        settings["listen"] = {"endpoints": []}
        settings["connect"] = {
            "endpoints": [endpoint],
            "timeout_ms": CONNECT_MS,
            "exit_on_failure": True,
            "retry": {"period_init_ms": 50, "period_max_ms": 200, "period_increase_factor": 1.5},
        }
    return zenoh.Config.from_json5(json.dumps(settings))


class Session:
    """A client of the run's router. Use as a context manager; received items are in `inbox`."""

    def __init__(self, endpoint: str, run: str) -> None:
        """Connect; waits some seconds for the router.

        Raises:
            EchelonError: the router cannot be reached.
        """
        self.run = run
        self.inbox: SimpleQueue[Incoming] = SimpleQueue()
        self._publishers: dict[str, zenoh.Publisher] = {}
        self._subscribers: dict[str, zenoh.Subscriber[None]] = {}
        self._declared: list[object] = []
        try:
            self._session = zenoh.open(config(endpoint=endpoint, router=False))
        except zenoh.ZError:
            raise EchelonError(f"expected a router at {endpoint}; nobody answers there") from None

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    @property
    def connected(self) -> bool:
        """Whether there is a link to the router now."""
        return bool(self._session.info.routers_zid())

    def subscribe(self, key: str) -> None:
        """Subscribe: samples on this key expression go to the inbox."""
        if "*" in key:

            def take(sample: zenoh.Sample) -> None:
                self.inbox.put(Sample(str(sample.key_expr), sample.payload.to_bytes()))
        else:

            def take(sample: zenoh.Sample) -> None:
                self.inbox.put(Sample(key, sample.payload.to_bytes()))

        self._subscribers[key] = self._session.declare_subscriber(key, zenoh.handlers.Callback(take, indirect=False))

    def keep(self, key: str, depth: int) -> "Kept":
        """Subscribe outside the inbox: keep the newest `depth` samples on this key expression."""
        return Kept(self._session.declare_subscriber(key, zenoh.handlers.RingChannel(depth)))

    def unsubscribe(self, key: str) -> None:
        """Unsubscribe from this key expression."""
        self._subscribers.pop(key).undeclare()  # type: ignore[no-untyped-call]

    def announce(self, key: str, *, reliable: bool = False) -> None:
        """Declare a publisher on `key`, so that the first message finds its subscribers.

        Args:
            key: a key without wildcards.
            reliable: wait for a slow subscriber rather than drop.
        """
        self._publishers[key] = self._session.declare_publisher(
            key,
            congestion_control=zenoh.CongestionControl.BLOCK if reliable else zenoh.CongestionControl.DROP,
            priority=zenoh.Priority.REAL_TIME if reliable else zenoh.Priority.DATA,
            express=True,
        )

    def publish(self, key: str, message: Message) -> None:
        """Publish on a key that was announced."""
        self._publishers[key].put(encode(message))

    def serve(self, key: str) -> None:
        """Declare a queryable: queries on this key go to the inbox."""

        def take(query: zenoh.Query) -> None:
            def answer(payload: bytes) -> None:
                with query:
                    query.reply(key, payload)

            self.inbox.put(Query(query.payload.to_bytes() if query.payload else b"", answer))

        self._declared.append(self._session.declare_queryable(key, zenoh.handlers.Callback(take, indirect=False)))

    def ask(self, what: Operation | Request, *, timeout: float = 2.0) -> Reply | None:
        """Send a request to the world of this run. None if it does not answer within `timeout` [s].

        Raises:
            WireError: the answer is not a Reply.
        """
        payload = self._query(what if isinstance(what, Request) else request(what), timeout)
        return None if payload is None else decode(Reply, payload)

    def setup(self, *, timeout: float = 1.0) -> Setup | None:
        """The Setup of this run's world. None if it does not answer within `timeout` [s].

        Raises:
            WireError: the answer is not a Setup.
        """
        payload = self._query(request(GetSetup()), timeout)
        return None if payload is None else decode(Setup, payload)

    def _query(self, message: Request, timeout: float) -> bytes | None:
        for reply in self._session.get(topics.control(self.run), payload=encode(message), timeout=timeout):
            if reply.ok:
                return bytes(reply.ok.payload.to_bytes())
        return None

    def appear(self, role: str, number: int = 0) -> None:
        """Declare a liveliness token, which lasts until this session closes or its process dies."""
        self._declared.append(self._session.liveliness().declare_token(topics.alive(self.run, role, number)))

    def watch(self) -> None:
        """Subscribe to liveliness: presence of this run's processes, now and later, goes to the inbox."""

        def take(sample: zenoh.Sample) -> None:
            *_, role, number = str(sample.key_expr).split("/")
            if number.isascii() and number.isdigit():
                self.inbox.put(Presence(role, int(number), sample.kind == zenoh.SampleKind.PUT))

        key = topics.alive(self.run, "*", "*")
        self._declared.append(
            self._session.liveliness().declare_subscriber(
                key, zenoh.handlers.Callback(take, indirect=False), history=True
            )
        )

    def incoming(self, seconds: float) -> Iterator[Incoming]:
        """Items received within this time [s], as they come; the reader may stop earlier."""
        until = monotonic() + seconds
        while (left := until - monotonic()) > 0:
            try:
                yield self.inbox.get(timeout=left)
            except Empty:
                return

    def wake(self) -> None:
        """Wake the reader of the inbox; safe in a signal handler."""
        self.inbox.put(Wake())

    def close(self) -> None:
        """Close the session, within CLOSE_SECONDS."""
        _close(self._session)


class Kept:
    """A ring of the newest samples, read on demand; overwritten samples never reach Python."""

    def __init__(self, subscriber: "zenoh.Subscriber[zenoh.Handler[zenoh.Sample]]") -> None:
        self._subscriber = subscriber

    def take(self) -> Iterator[Sample]:
        """The samples since the last call, oldest first."""
        while (sample := self._subscriber.try_recv()) is not None:
            yield Sample(str(sample.key_expr), sample.payload.to_bytes())


class Router:
    """The run's router: all traffic passes it, and no other process listens."""

    def __init__(self, endpoint: str) -> None:
        """Listen on unixsock-stream/PATH or tcp/HOST:PORT.

        Raises:
            EchelonError: it cannot listen there.
        """
        try:
            self._session = zenoh.open(config(endpoint=endpoint, router=True))
        except zenoh.ZError as error:
            text = str(error).split(" at ")[0][:200]
            raise EchelonError(f"expected an endpoint to listen on; {endpoint} cannot be used: {text}") from None

    def close(self) -> None:
        """Stop listening."""
        _close(self._session)


def _close(session: zenoh.Session) -> None:
    """Close within the time limit; a process with an open session could never exit, so it is ended otherwise."""
    closer = threading.Thread(target=session.close, daemon=True)
    closer.start()
    closer.join(CLOSE_SECONDS)
    if closer.is_alive():
        os._exit(1)
