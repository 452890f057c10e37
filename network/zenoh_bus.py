"""A process's connection to its run: one Zenoh session, and one inbox for everything that it receives.

All that arrives (samples, queries, responses, processes that come and go) lands in one queue in the order of arrival.
Zenoh's own receive threads only append to it, so a slow reader never stalls the session, and a reader can wait with a
time limit. Besides ros/session.py this is the only module that imports zenoh.
"""

import ctypes
import json
import os
import threading
from collections.abc import Iterator, Sequence
from typing import Any

import zenoh

from formation.errors import EchelonError
from network import control, topics
from network.access.keys import LOCAL, Keys, check, protocol
from network.access.rules import access_list
from network.bus import QUIET, Attendance, Bus, Connection, Incoming, Query, Response, Sample
from network.codec import MAX_BYTES, encode
from network.inbox import Inbox
from network.messages import Message
from network.requests import Request

LEASE_MS = 10_000
"""Zenoh's lease: a process that sends nothing for this long counts as gone. Each side announces its own.

On one machine a process that dies closes its socket, which is seen at once; the lease is for one that is frozen, and
then lockstep waits rather than goes on without it.
"""
NETWORK_LEASE_MS = 1000
"""The same of processes that reach the run over a network: a cable that is pulled closes no socket."""
CONNECT_SECONDS = 10.0
"""Longest wait for a router that is just starting, or coming back [s]."""
CLOSE_SECONDS = 2.0
"""Time limit for closing a session [s]; on a dead link it would take ten seconds."""
REFUSAL_SECONDS = 1.0
"""A router that has not let a process in for this long is asked why [s]."""
REQUEST_SECONDS = 1.0
"""A request that is not answered for this long never is [s]."""


def _settings(mode: str, endpoints: Sequence[str], keys: Keys | None) -> dict[str, Any]:
    """Of a session with the router only: no scouting, no other listeners, no shared memory."""
    lease = LEASE_MS if all(protocol(endpoint) == LOCAL for endpoint in endpoints) else NETWORK_LEASE_MS
    link: dict[str, Any] = {"tx": {"lease": lease, "keep_alive": 4}}
    if keys is not None:
        link["tls"] = keys.settings(listening=mode == "router")
    return {
        "mode": mode,
        "scouting": {"multicast": {"enabled": False}, "gossip": {"enabled": False}, "delay": 1},
        "transport": {"link": link, "shared_memory": {"enabled": False}},
        "listen": {"endpoints": []},
    }


def client_config(endpoint: str, *, keys: Keys | None = None, patience: float = CONNECT_SECONDS) -> zenoh.Config:
    """Of a session with a router, which is waited for so long [s]."""
    settings = _settings("client", [endpoint], keys)
    settings["connect"] = {
        "endpoints": [endpoint],
        "timeout_ms": round(patience * 1e3),
        "exit_on_failure": True,
        "retry": {"period_init_ms": 50, "period_max_ms": 200, "period_increase_factor": 1.5},
    }
    return zenoh.Config.from_json5(json.dumps(settings))


_THREAD = threading.local()


def _keep_thread() -> None:
    """Have Python keep its state of this thread of Zenoh's: else it maps memory for one at each message."""
    if not hasattr(_THREAD, "kept"):
        _THREAD.kept = ctypes.pythonapi.PyGILState_Ensure()


class ZenohBus(Bus):
    """A client of the run's router."""

    def __init__(
        self,
        endpoint: str,
        run: str,
        *,
        keys: Keys | None = None,
        insecure: bool = False,
        patience: float = CONNECT_SECONDS,
    ) -> None:
        """Connect.

        Args:
            endpoint: of the router.
            run: name of the run.
            keys: for any endpoint but a unix socket.
            insecure: accept an endpoint that strangers can use.
            patience: longest wait for the router [s].

        Raises:
            EchelonError: the router cannot be reached, or one of the two refuses the other.
        """
        check(endpoint, keys, insecure=insecure)
        self.run = run
        self.inbox: Inbox[Incoming] = Inbox()
        self._publishers: dict[str, zenoh.Publisher] = {}
        self._subscribers: dict[str, zenoh.Subscriber[None]] = {}
        self._declared: list[object] = []
        try:
            self._session = self._opened(endpoint, keys, patience)
        except zenoh.ZError:
            raise EchelonError(f"expected a router at {endpoint}; nobody answers there") from None

    def _opened(self, endpoint: str, keys: Keys | None, patience: float) -> zenoh.Session:
        if keys is None or patience <= REFUSAL_SECONDS:
            return zenoh.open(client_config(endpoint, keys=keys, patience=patience))
        try:
            return zenoh.open(client_config(endpoint, keys=keys, patience=REFUSAL_SECONDS))
        except zenoh.ZError:
            from network.access.refusal import refusal  # noqa: PLC0415  slow, and seldom wanted

            reason = refusal(endpoint, keys)
            if reason is not None:
                raise EchelonError(reason) from None
            return zenoh.open(client_config(endpoint, keys=keys, patience=patience - REFUSAL_SECONDS))

    @property
    def connected(self) -> bool:
        return bool(self._session.info.routers_zid())

    def subscribe(self, key: str) -> None:
        quietly = key.endswith(QUIET)
        if "*" in key:

            def take(sample: zenoh.Sample) -> None:
                _keep_thread()
                self.inbox.put(Sample(str(sample.key_expr), _bytes(sample.payload)), quietly=quietly)
        else:

            def take(sample: zenoh.Sample) -> None:
                _keep_thread()
                self.inbox.put(Sample(key, _bytes(sample.payload)), quietly=quietly)

        self._subscribers[key] = self._session.declare_subscriber(key, zenoh.handlers.Callback(take, indirect=False))

    def keep(self, key: str, depth: int) -> "KeptSamples":
        return KeptSamples(self._session.declare_subscriber(key, zenoh.handlers.RingChannel(depth)))

    def unsubscribe(self, key: str) -> None:
        self._subscribers.pop(key).undeclare()  # type: ignore[no-untyped-call]

    def announce(self, key: str, *, reliable: bool = False, packed: bool = False) -> None:
        self._publishers[key] = self._session.declare_publisher(
            key,
            congestion_control=zenoh.CongestionControl.BLOCK if reliable else zenoh.CongestionControl.DROP,
            priority=zenoh.Priority.REAL_TIME if reliable else zenoh.Priority.DATA,
            reliability=zenoh.Reliability.RELIABLE if reliable else zenoh.Reliability.BEST_EFFORT,
            express=not packed,  # else each message is a packet: a write, and for each receiver a read
        )

    def publish(self, key: str, message: Message) -> None:
        self._publishers[key].put(encode(message))

    def serve(self, key: str) -> None:
        def take(query: zenoh.Query) -> None:
            def answer(payload: bytes) -> None:
                with query:
                    query.reply(key, payload)

            self.inbox.put(Query(_bytes(query.payload) if query.payload else b"", answer, key))

        self._declared.append(self._session.declare_queryable(key, zenoh.handlers.Callback(take, indirect=False)))

    def request(self, message: Request) -> None:
        def take(reply: zenoh.Reply) -> None:
            if reply.ok:
                self.inbox.put(Response(message, _bytes(reply.ok.payload)))

        self._session.get(
            control.key(self.run, message),
            zenoh.handlers.Callback(take, indirect=False),
            payload=encode(message),
            timeout=REQUEST_SECONDS,
        )

    def fetch(self, message: Request, timeout: float) -> bytes | None:
        for reply in self._session.get(control.key(self.run, message), payload=encode(message), timeout=timeout):
            if reply.ok:
                return _bytes(reply.ok.payload)
        return None

    def stamps(self, key: str) -> Inbox[tuple[float, float]]:
        """Of samples: when they passed the router by its clock, and arrived here by ours [s since 1970]."""
        found: Inbox[tuple[float, float]] = Inbox()

        def take(sample: zenoh.Sample) -> None:
            here = self._session.new_timestamp().get_time().timestamp()
            if sample.timestamp is not None:
                found.put((sample.timestamp.get_time().timestamp(), here))

        self._declared.append(self._session.declare_subscriber(key, zenoh.handlers.Callback(take, indirect=False)))
        return found

    @property
    def session(self) -> str:
        """What tells its tokens from those of another process: it outlives an outage of the router."""
        return str(self._session.zid())

    def appear(self, role: str, number: int = 0) -> None:
        key = topics.alive(self.run, role, number, self.session)
        self._declared.append(self._session.liveliness().declare_token(key))

    def watch(self) -> None:
        attendance = Attendance()

        def take(sample: zenoh.Sample) -> None:
            *_, role, number, session = str(sample.key_expr).split("/")
            if number.isascii() and number.isdigit():
                here = sample.kind == zenoh.SampleKind.PUT
                changed = attendance.note(role, int(number), session, here=here)
                if changed is not None:
                    self.inbox.put(changed)

        def note(event: zenoh.TransportEvent) -> None:
            self.inbox.put(Connection(event.kind == zenoh.SampleKind.PUT))

        callback = zenoh.handlers.Callback(note, indirect=False)
        self._declared.append(self._session.info.declare_transport_events_listener(callback, history=True))
        self._declared.append(
            self._session.liveliness().declare_subscriber(
                topics.ALIVE.key(self.run), zenoh.handlers.Callback(take, indirect=False), history=True
            )
        )

    def close(self) -> None:
        """Leave the network; never takes longer than CLOSE_SECONDS."""
        close_session(self._session)


class KeptSamples:
    """Samples that wait in Zenoh until they are read, and cost no Python before."""

    def __init__(self, subscriber: "zenoh.Subscriber[zenoh.Handler[zenoh.Sample]]") -> None:
        self._subscriber = subscriber

    def take(self) -> Iterator[Sample]:
        """Everything that has come in since the last look, oldest first."""
        while (sample := self._subscriber.try_recv()) is not None:
            yield Sample(str(sample.key_expr), _bytes(sample.payload))


class Router:
    """The run's router: everything goes through it, nothing else listens."""

    def __init__(
        self, endpoints: Sequence[str], run: str = "", *, keys: Keys | None = None, insecure: bool = False
    ) -> None:
        """Listen.

        Args:
            endpoints: unixsock-stream/PATH, tls/HOST:PORT, quic/HOST:PORT, or those that strangers can use.
            run: with keys, the run that they are for.
            keys: for any endpoint but a unix socket.
            insecure: listen on endpoints that strangers can use.

        Raises:
            EchelonError: it cannot listen there.
        """
        for endpoint in endpoints:
            check(endpoint, keys, insecure=insecure)
        settings = _settings("router", endpoints, keys)
        settings["listen"]["endpoints"] = list(endpoints)
        if keys is not None:
            settings["access_control"] = access_list(run)
        try:
            self._session = zenoh.open(zenoh.Config.from_json5(json.dumps(settings)))
        except zenoh.ZError as error:
            text = str(error).split(" at ")[0][:200]
            where = ", ".join(endpoints)
            raise EchelonError(f"expected an endpoint to listen on; {where} cannot be used: {text}") from None

    def close(self) -> None:
        """Stop listening."""
        close_session(self._session)


def _bytes(payload: zenoh.ZBytes) -> bytes:
    """What came in; nothing, which is no message, of what is too large for one: it is not even copied."""
    return bytes(payload.to_bytes()) if len(payload) <= MAX_BYTES else b""


def close_session(session: zenoh.Session) -> None:
    """Close within the time limit; a process that left a session open could never exit, so then it is ended."""
    closer = threading.Thread(target=session.close, daemon=True)
    closer.start()
    closer.join(CLOSE_SECONDS)
    if closer.is_alive():
        os._exit(1)
