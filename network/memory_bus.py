"""A network inside one process, without threads and without a clock: what happens to each message is programmed.

A test, or a program that runs world and agents in one process, makes a MemoryHub, lets every node join it, and moves
its time on by hand. The same fates give the same arrivals in the same order, always.
"""

import heapq
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from typing import NamedTuple

from network import control
from network.bus import QUIET, Attendance, Bus, Connection, Incoming, Query, Response, Sample
from network.codec import encode
from network.inbox import Inbox
from network.messages import Message
from network.requests import Request


class Letter(NamedTuple):
    """A sample, request or response on its way from one process to another."""

    number: int
    """Of the hub's letters, from 0."""
    sender: str
    receiver: str
    key: str
    """For a request or a response: that of the control topic."""


Fate = Callable[[Letter], Sequence[float]]
"""What becomes of a letter: a delay [s] for each copy that arrives. () loses it, (0.0, 0.3) doubles it."""


def prompt(letter: Letter) -> Sequence[float]:
    """Nothing happens to it: it arrives at once."""
    del letter
    return (0.0,)


class MemoryHub:
    """The router of MemoryBuses: carries letters, knows its clients, goes down and comes back."""

    def __init__(self, fate: Fate = prompt) -> None:
        self.fate = fate
        self.now = 0.0
        """Time of the network [s]; `advance` moves it on."""
        self.buses: list[MemoryBus] = []
        """Those that have joined and not closed."""
        self._due: list[tuple[float, int, Callable[[], object]]] = []
        self._order = self._letters = 0

    def join(self, run: str = "memory", name: str = "") -> "MemoryBus":
        """A new process's place; `name` is what Letters call it."""
        bus = MemoryBus(self, run, name or f"process {self._order}", session=str(self._order))
        self._order += 1
        self.buses.append(bus)
        return bus

    # ------------------------------------------------------------------ time

    @property
    def next_due(self) -> float:
        """When the next letter arrives, or something else happens [s]; infinite if nothing is on its way."""
        return self._due[0][0] if self._due else float("inf")

    def advance(self, now: float) -> None:
        """On to this time [s]: everything that is due until then arrives."""
        while self._due and self._due[0][0] <= now:
            due, _, act = heapq.heappop(self._due)
            self.now = max(self.now, due)
            act()
        self.now = max(self.now, now)

    def later(self, delay: float, act: Callable[[], object]) -> None:
        """Have something happen after so long [s]."""
        self._order += 1
        heapq.heappush(self._due, (self.now + delay, self._order, act))

    # ------------------------------------------------------------------ connections

    def disconnect(self, *buses: "MemoryBus") -> None:
        """The links of these processes to the router go down; of all, if none is named. Letters on the way arrive."""
        down = [bus for bus in buses or self.buses if bus.connected]
        for bus in down:
            bus.up = False
        for watcher in [bus for bus in self.buses if bus.watching]:
            lost_all = watcher in down
            for bus in self.buses if lost_all else down:
                watcher.receive_presence(bus, here=False)
            if lost_all:
                watcher.receive(Connection(False))

    def connect(self, *buses: "MemoryBus") -> None:
        """The links of these processes come up; of all, if none is named."""
        for bus in [bus for bus in buses or self.buses if bus in self.buses and not bus.connected]:
            bus.up = True
            if bus.watching:
                bus.receive(Connection(True))
                for other in self.buses:
                    bus.receive_presence(other, here=other.connected)
            for watcher in self.buses:
                if watcher.watching and watcher.connected and watcher is not bus:
                    watcher.receive_presence(bus, here=True)

    # ------------------------------------------------------------------ letters

    def carry(self, sender: "MemoryBus", receiver: "MemoryBus", key: str, deliver: Callable[[], None]) -> None:
        """Take a letter on its way, and have it delivered as its fate has it."""
        if not (sender.connected and receiver.connected):
            return
        letter = Letter(self._letters, sender.name, receiver.name, key)
        self._letters += 1
        for delay in self.fate(letter):
            if delay <= 0.0:
                deliver()
            else:
                self.later(delay, deliver)


class MemoryBus(Bus):
    """A process's place on a MemoryHub."""

    def __init__(self, hub: MemoryHub, run: str, name: str, *, session: str) -> None:
        self.run, self.name, self.session = run, name, session
        self.inbox: Inbox[Incoming] = Inbox()
        self.up = True
        """Whether it is connected; set by the hub."""
        self.watching = False
        self.react: Callable[[Incoming], object] | None = None
        """If set, what comes in is given to it at once instead of waiting in the inbox."""
        self._hub = hub
        self._announced: set[str] = set()
        self._subscribed: set[str] = set()
        self._served: set[str] = set()
        self._kept: list[tuple[str, KeptInMemory]] = []
        self._tokens: list[tuple[str, int]] = []
        self._attendance = Attendance()

    @property
    def connected(self) -> bool:
        return self.up

    def subscribe(self, key: str) -> None:
        self._subscribed.add(key)

    def unsubscribe(self, key: str) -> None:
        self._subscribed.remove(key)

    def keep(self, key: str, depth: int) -> "KeptInMemory":
        kept = KeptInMemory(depth)
        self._kept.append((key, kept))
        return kept

    def announce(self, key: str, *, reliable: bool = False, packed: bool = False) -> None:
        self._announced.add(key)

    def publish(self, key: str, message: Message) -> None:
        if key not in self._announced:
            raise KeyError(key)
        sample = Sample(key, encode(message))
        for bus in list(self._hub.buses):
            if bus.run == self.run and bus.wants(key):
                self._hub.carry(self, bus, key, partial(bus.receive, sample))

    def serve(self, key: str) -> None:
        self._served.add(key)

    def request(self, message: Request) -> None:
        self._query(message, lambda payload: self.receive(Response(message, payload)))

    def fetch(self, message: Request, timeout: float) -> bytes | None:
        """None unless the answer comes at once: no other process runs while this one waits (see `react`)."""
        answers: list[bytes] = []
        self._query(message, answers.append)
        return answers[0] if answers else None

    def _query(self, message: Request, take: Callable[[bytes], None]) -> None:
        hub, key = self._hub, control.key(self.run, message)
        for server in [bus for bus in hub.buses if bus.run == self.run and key in bus._served]:

            def answer(payload: bytes, server: MemoryBus = server) -> None:
                hub.carry(server, self, key, partial(take, payload))

            hub.carry(self, server, key, partial(server.receive, Query(encode(message), answer, key)))

    def appear(self, role: str, number: int = 0) -> None:
        self._tokens.append((role, number))
        for bus in self._hub.buses:
            if bus.watching and bus.connected and self.connected and bus.run == self.run:
                bus.note_token(role, number, self.session, here=True)

    def watch(self) -> None:
        self.watching = True
        self.receive(Connection(self.connected))
        for bus in self._hub.buses:
            if bus.connected and self.connected:
                self.receive_presence(bus, here=True)

    def close(self) -> None:
        """Leave the network; as the death of the process does."""
        if self in self._hub.buses:
            self._hub.disconnect(self)
            self._hub.buses.remove(self)

    def wants(self, key: str) -> bool:
        """Whether a subscription of this process matches the key."""
        patterns = [*self._subscribed, *(pattern for pattern, _ in self._kept)]
        return any(_matches(pattern, key) for pattern in patterns)

    def receive(self, item: Incoming) -> None:
        """Something arrives."""
        if isinstance(item, Sample):
            for pattern, kept in self._kept:
                if _matches(pattern, item.key):
                    kept.put(item)
            if not any(_matches(pattern, item.key) for pattern in self._subscribed):
                return
        if self.react is not None:
            self.react(item)
        else:
            self.inbox.put(item, quietly=isinstance(item, Sample) and item.key.endswith(QUIET))

    def receive_presence(self, other: "MemoryBus", *, here: bool) -> None:
        """Another process, or this one, has come or gone."""
        if other.run == self.run:
            for role, number in other._tokens:
                self.note_token(role, number, other.session, here=here)

    def note_token(self, role: str, number: int, session: str, *, here: bool) -> None:
        """A token has come or gone."""
        changed = self._attendance.note(role, number, session, here=here)
        if changed is not None:
            self.receive(changed)


class KeptInMemory:
    """The newest samples, read on demand."""

    def __init__(self, depth: int) -> None:
        self._samples: deque[Sample] = deque(maxlen=depth)

    def put(self, sample: Sample) -> None:
        """A sample has arrived."""
        self._samples.append(sample)

    def take(self) -> Iterator[Sample]:
        """Everything that has come in since the last look, oldest first."""
        while self._samples:
            yield self._samples.popleft()


def _matches(pattern: str, key: str) -> bool:
    """Whether a key expression, in which * stands for one part, matches a key."""
    if pattern == key:
        return True
    theirs, ours = key.split("/"), pattern.split("/")
    return len(ours) == len(theirs) and all(a in ("*", b) for a, b in zip(ours, theirs, strict=True))
