"""What a process needs of a network: the Bus, what comes in over it, and what a node may have sent.

A node (agents/node.py, world/node.py, runtime/ghost/process.py) does no I/O. Its process is a loop of three steps: take
the arrivals from the bus, feed them to the node, perform the actions that the node returns. There are two buses:
network/zenoh_bus.py between processes, and network/memory_bus.py inside one.
"""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field
from queue import Empty
from time import monotonic
from types import TracebackType
from typing import NamedTuple, Protocol, Self

from network.codec import decode
from network.control import GetSetup, Operation, request
from network.inbox import Inbox
from network.messages import Message
from network.requests import Reply, Request, Setup
from network.throttled_log import ThrottledLog

QUIET = ("/plan", "/command", "/status")
"""Ends of the keys whose samples a reader need not be woken for one by one."""
MAX_ARRIVALS = 1000
"""Arrivals that are taken at a time, so that a flood does not keep a process from its work."""


class Sample(NamedTuple):
    """A payload that was published."""

    key: str
    payload: bytes


@dataclass(frozen=True, slots=True)
class Query:
    """A payload that waits for an answer; `answer` may be called from any thread, once."""

    payload: bytes
    answer: Callable[[bytes], None]
    key: str = ""
    """On which it was asked; empty for what a process asks of itself."""


class Response(NamedTuple):
    """The answer to a request that was sent with `Bus.request`."""

    request: Request
    payload: bytes


@dataclass(frozen=True, slots=True)
class Presence:
    """A process has come or gone, or another has taken its place."""

    role: str
    number: int
    here: bool
    session: str = field(default="", compare=False)
    """Of the process: it outlives an outage of the router, but not the process."""


class Attendance:
    """Who is here, by the tokens of their sessions: for one role and number there may be several for a while."""

    def __init__(self) -> None:
        self._sessions: dict[tuple[str, int], list[str]] = {}

    def note(self, role: str, number: int, session: str, *, here: bool) -> Presence | None:
        """A token has come or gone. What that says of its role and number: the newest session counts; None: nothing."""
        sessions = self._sessions.setdefault((role, number), [])
        before = sessions[-1:]
        if here and session not in sessions:
            sessions.append(session)
        elif not here and session in sessions:
            sessions.remove(session)
        after = sessions[-1:]
        return None if before == after else Presence(role, number, bool(after), (after or before)[0])


class Read(NamedTuple):
    """A message that this process has decoded, or sent, for several of its nodes."""

    key: str
    message: Message


class Connection(NamedTuple):
    """The link between this process and the router came up or went down."""

    up: bool


class Wake:
    """Put into an inbox to wake its reader."""


Incoming = Sample | Read | Query | Response | Presence | Connection | Wake


class Subscribe(NamedTuple):
    """Samples on this key expression shall arrive."""

    key: str


class Unsubscribe(NamedTuple):
    """Samples on this key expression shall no longer arrive."""

    key: str


class Announce(NamedTuple):
    """Prepare to publish on this key, so that the first message finds its subscribers."""

    key: str
    reliable: bool
    packed: bool = False
    """As in `Bus.announce`."""


class Appear(NamedTuple):
    """Be seen as alive from now on."""

    role: str
    number: int = 0


class Publish(NamedTuple):
    """Send a message to the subscribers of the key."""

    key: str
    message: Message


class Ask(NamedTuple):
    """Send a request to the world; what it answers arrives as a Response, or never."""

    request: Request


class Respond(NamedTuple):
    """Answer a query."""

    query: Query
    payload: bytes


class Reject(NamedTuple):
    """Log that a payload on this key was not a valid message."""

    key: str
    reason: str


Action = Publish | Ask | Respond | Subscribe | Unsubscribe | Announce | Appear | Reject


class Kept(Protocol):
    """A ring of the newest samples, read on demand; older ones are overwritten."""

    def take(self) -> Iterator[Sample]:
        """Everything that has come in since the last look, oldest first."""


class Bus(Protocol):
    """A process's place on the network of a run. Use as a context manager.

    The order of arrivals is the order in `inbox`. A bus may lose, double, delay and reorder samples, requests and
    responses. Presence and Connection arrive in order and are not lost: they are states, and a bus repeats them.
    """

    run: str
    """Name of the run."""
    inbox: Inbox[Incoming]
    """What has arrived; read it with `arrivals`."""

    @property
    def connected(self) -> bool:
        """Whether there is a link to the router now."""

    def subscribe(self, key: str) -> None:
        """Samples on this key expression arrive from now on."""

    def unsubscribe(self, key: str) -> None:
        """No more samples on this key expression, which was subscribed to before."""

    def keep(self, key: str, depth: int) -> Kept:
        """Samples on this key expression are kept outside the inbox from now on, the newest `depth` of them."""

    def announce(self, key: str, *, reliable: bool = False, packed: bool = False) -> None:
        """Prepare to publish on `key`, so that the first message finds its subscribers.

        Args:
            key: a key without wildcards.
            reliable: wait for a slow subscriber rather than drop.
            packed: its messages may share a packet with what is published just before and after them.
        """

    def publish(self, key: str, message: Message) -> None:
        """Publish a message on an announced key."""

    def serve(self, key: str) -> None:
        """Queries on this key arrive from now on."""

    def request(self, message: Request) -> None:
        """Ask the world of this run without waiting; its answer arrives as a Response, or never."""

    def fetch(self, message: Request, timeout: float) -> bytes | None:
        """Ask the world of this run and wait. None if it does not answer within `timeout` [s]."""

    def appear(self, role: str, number: int = 0) -> None:
        """Be seen as alive until this bus closes or its process dies."""

    def watch(self) -> None:
        """Presence of this run's processes and the state of the Connection arrive, now and whenever they change."""

    def close(self) -> None:
        """Leave the network."""

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def arrivals(self, seconds: float = 0.0, enough: int = 1) -> list[Incoming]:
        """What has come in, oldest first; if nothing has, wait at most so long [s] for something.

        Args:
            seconds: longest wait.
            enough: so many plans, commands and statuses end the wait, or anything else.
        """
        inbox = self.inbox
        try:
            found = [inbox.get(seconds, enough) if seconds > 0.0 else inbox.get_nowait()]
        except Empty:
            return []
        while len(found) < MAX_ARRIVALS and not inbox.empty():  # only this process's loop takes from the inbox
            found.append(inbox.get_nowait())
        return found

    def incoming(self, seconds: float) -> Iterator[Incoming]:
        """What comes in within so long [s], as it comes; the reader may stop earlier."""
        until = monotonic() + seconds
        while (left := until - monotonic()) > 0.0:
            yield from self.arrivals(left)

    def wake(self) -> None:
        """Wake the reader that waits for arrivals; safe in any thread and in a signal handler."""
        self.inbox.put(Wake())

    def ask(self, what: Operation | Request, *, timeout: float = 2.0) -> Reply | None:
        """Ask the world of this run. None if it does not answer within `timeout` [s].

        Raises:
            WireError: the answer is not a Reply.
        """
        payload = self.fetch(what if isinstance(what, Request) else request(what), timeout)
        return None if payload is None else decode(Reply, payload)

    def setup(self, *, timeout: float = 1.0) -> Setup | None:
        """The Setup of this run's world. None if it does not answer within `timeout` [s].

        Raises:
            WireError: the answer is not a Setup.
        """
        payload = self.fetch(request(GetSetup()), timeout)
        return None if payload is None else decode(Setup, payload)


def perform(bus: Bus, actions: Iterable[Action], log: ThrottledLog) -> None:
    """Do what a node wants done, in order."""
    for action in actions:
        match action:
            case Publish(key, message):
                bus.publish(key, message)
            case Ask(message):
                bus.request(message)
            case Respond(query, payload):
                query.answer(payload)
            case Subscribe(key):
                bus.subscribe(key)
            case Unsubscribe(key):
                bus.unsubscribe(key)
            case Announce(key, reliable, packed):
                bus.announce(key, reliable=reliable, packed=packed)
            case Appear(role, number):
                bus.appear(role, number)
            case Reject(key, reason):
                log.add(key, reason)
