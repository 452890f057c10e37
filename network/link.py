"""One faulty directed link, without any I/O: push what was sent, pop what is due (docs/design.md, section 4).

It stands at the receiver. What happens to a message is drawn from (seed, source, target, seq) alone, so the same
messages meet the same faults whatever the controller, the timing or the machine.
"""

import hashlib
import heapq
import math
import struct
from collections import deque
from statistics import NormalDist
from typing import Any, Generic, NamedTuple, TypeVar

from formation.faults import PERFECT, Fault
from formation.link_ids import LinkId
from network.values import LinkCounts

QUEUE_LIMIT = 10
"""Messages that wait for a rate-limited link before further ones are lost."""
PARETO_SHAPE = 3.0
"""Tail index of pareto jitter: finite mean and variance, the occasional very late message."""
MEMORY = 4096
"""Messages that a burst is traced back at most; beyond, the chain starts from its stationary distribution."""

T = TypeVar("T")
_SEQ, _WORDS = struct.Struct("<q"), struct.Struct("<8Q")
LOSS, JITTER, DUPLICATE, REORDER, CORRUPT, COPY_JITTER, PLACE, STATIONARY = range(8)
"""Which of a message's random words decides what; `_uniform` makes a number in [0, 1) of one that a fault asks for."""
UNUSED = (0,) * 8
"""Words for a fault that leaves nothing to chance."""


class Arrival(NamedTuple, Generic[T]):
    """A delivered message."""

    seq: int
    sent: float
    """[s]."""
    due: float
    """When it arrived [s]; never before it was sent."""
    message: T
    damage: float | None
    """If not None, the message came with flipped bytes: those of `damaged(its bytes, damage)`."""


class _Departure(NamedTuple):
    """Of a message, or of a copy of it, over a rate-limited link."""

    at: float
    delay: float
    """From there to its arrival [s]."""
    number: int
    """In the heap."""


class Link(Generic[T]):
    """A link from `source` to `target`. `fault` may be set at any time; it applies to messages pushed afterwards.

    Its rate applies to those that wait for their departure as well: a queue drains at the rate that the link has.
    """

    def __init__(self, seed: int, link: LinkId, fault: Fault = PERFECT) -> None:
        self.id = link
        self._key = f"{seed}/{link}".encode()[:64]
        self._hash: hashlib.blake2b | None = None  # of the key: half of what a draw takes is saved by copying it
        self._heap: list[tuple[float, int, Arrival[T]]] = []
        self._order = 0
        self._free = -math.inf  # when a rate-limited link can take the next message
        self._rate = 0.0  # by which that was computed
        self._departures: deque[_Departure] = deque()  # the last one that is over, and those that are to come
        self._latest = -math.inf  # the latest arrival so far, for keep_order
        self._popped = -math.inf  # the latest of those that were popped
        self._looked = -math.inf  # when that was
        self._sent = self._lost = self._delivered = self._duplicated = 0
        self._chain: tuple[int, float, float, bool] = (-1, 0.0, 0.0, False)  # seq, loss, burst, in a burst
        self.fault = fault

    def __getstate__(self) -> dict[str, Any]:
        """All but what is made of the key again."""
        return {**self.__dict__, "_hash": None}

    @property
    def counts(self) -> LinkCounts:
        """sent + duplicated = delivered + lost + in_flight, always."""
        return LinkCounts(
            sent=self._sent,
            delivered=self._delivered,
            lost=self._lost,
            duplicated=self._duplicated,
            in_flight=len(self._heap),
        )

    @property
    def fault(self) -> Fault:
        """What the link does to messages."""
        return self._fault

    @fault.setter
    def fault(self, fault: Fault) -> None:
        self._fault = PERFECT if fault is PERFECT or fault == PERFECT else fault
        self._random = any((fault.loss, fault.jitter, fault.duplicate, fault.reorder, fault.corrupt))
        self._bursts = 0.0 < fault.loss < 1.0 and fault.burst * (1.0 - fault.loss) > 1.0
        if fault.rate != self._rate and not self._heap:  # nothing waits; what waits is seen to when it is known when
            self._queue_anew(self._looked)

    @property
    def transparent(self) -> bool:
        """Whether a message pushed now would be popped now, alone."""
        return self._fault is PERFECT and not self._heap

    def push(self, seq: int, sent: float, message: T) -> None:
        """Send a message over the link. Messages must be pushed in the order in which they were sent."""
        self._sent += 1
        fault = self._fault
        if fault.rate != self._rate:
            self._queue_anew(max(sent, self._looked))
        if fault is PERFECT:
            self._carry(sent, 0.0, Arrival(seq, sent, sent, message, None))
            return
        words = self._words(seq) if self._random else UNUSED
        lost = fault.cut or (self._in_burst(seq) if self._bursts else _uniform(words[LOSS]) < fault.loss)
        departure = None if lost else self._departure(sent) if fault.rate else sent
        if departure is None:
            self._lost += 1
            return
        damage = _uniform(words[PLACE]) if fault.corrupt and _uniform(words[CORRUPT]) < fault.corrupt else None
        overtakes = fault.reorder and _uniform(words[REORDER]) < fault.reorder
        delay = 0.0 if overtakes else _delay(fault, words[JITTER]) if fault.jitter else fault.latency
        arrival = Arrival(seq, sent, departure + delay, message, damage)
        self._carry(departure, delay, arrival)
        if fault.duplicate and _uniform(words[DUPLICATE]) < fault.duplicate:
            self._duplicated += 1
            self._carry(departure, _delay(fault, words[COPY_JITTER]), arrival)

    def pop(self, now: float) -> list[Arrival[T]]:
        """Everything that has arrived by `now` [s] and was not popped before, in the order of arrival."""
        heap = self._heap
        if not heap:
            return []
        self._looked = now if now > self._looked else self._looked
        if self._fault.rate != self._rate:
            self._queue_anew(self._looked)
            heap = self._heap
        due: list[Arrival[T]] = []
        while heap and heap[0][0] <= now + 1e-9:  # stamps are k * delta_t: forgive rounding
            due.append(heapq.heappop(heap)[2])
        if due:
            self._delivered += len(due)
            last = due[-1].due
            self._popped = last if last > self._popped else self._popped
        return due

    def _carry(self, departure: float, delay: float, arrival: Arrival[T]) -> None:
        """What departs then [s] arrives after this delay [s]."""
        self._order += 1
        heapq.heappush(self._heap, self._due(departure, delay, self._order, arrival))
        if self._rate:
            self._departures.append(_Departure(departure, delay, self._order))
            while len(self._departures) > 1 and self._departures[1].at <= arrival.sent:
                self._departures.popleft()

    def _due(self, departure: float, delay: float, number: int, arrival: Arrival[T]) -> tuple[float, int, Arrival[T]]:
        """The heap's entry, with the time of arrival."""
        due = departure + delay
        if due < self._latest:
            if self._fault.keep_order:
                due = self._latest
        else:
            self._latest = due
        return due, number, arrival if due == arrival.due else arrival._replace(due=due)

    def _queue_anew(self, now: float) -> None:
        """The rate has changed: what waits at `now` [s] departs at the new one, after what has departed."""
        self._rate = self._fault.rate
        gap = 1.0 / self._rate if self._rate else 0.0
        over = [one for one in self._departures if one.at <= now + 1e-9]
        waiting = [one for one in self._departures if one.at > now + 1e-9]
        self._departures = deque(over[-1:] if self._rate else ())
        self._free = over[-1].at + gap if over and self._rate else -math.inf
        entries = {entry[1]: entry for entry in self._heap}
        moved = [(one, entries.pop(one.number)) for one in waiting]
        self._heap = list(entries.values())
        self._latest = max([self._popped, *(entry[0] for entry in self._heap)])
        before, departure = -math.inf, now
        for one, (_, number, arrival) in moved:
            if one.at != before:  # a copy departs with its message
                before, departure = one.at, max(now, self._free, arrival.sent)
                self._free = departure + gap
            self._heap.append(self._due(departure, one.delay, number, arrival))
            if self._rate:
                self._departures.append(_Departure(departure, one.delay, number))
        heapq.heapify(self._heap)

    def _departure(self, sent: float) -> float | None:
        """When a rate-limited link forwards the message [s]; None if its queue is full."""
        departure = max(sent, self._free)
        if (departure - sent) * self._fault.rate > QUEUE_LIMIT:
            return None
        self._free = departure + 1.0 / self._fault.rate
        return departure

    def _in_burst(self, seq: int) -> bool:
        """Gilbert-Elliott: a chain that turns bad with probability p and good with r = 1 / burst, by seq.

        Both states see the same draw u of a message: below p it turns bad whatever it was, from 1 - r on it turns
        good, in between it stays (p < 1 - r here). So the last deciding draw settles it, and the state of the
        message before, where it is known, only saves looking back.
        """
        loss, burst = self._fault.loss, self._fault.burst
        r = 1.0 / burst
        p = loss * r / (1.0 - loss)
        known, *model, state = self._chain
        warm = model == [loss, burst] and known < seq
        first = known + 1 if warm else max(0, seq - MEMORY)
        for back in range(seq, first - 1, -1):
            u = _uniform(self._words(back)[LOSS])
            if u < p or u >= 1.0 - r:
                state = u < p
                break
        else:
            if not warm:
                state = _uniform(self._words(first)[STATIONARY]) < loss
        self._chain = (seq, loss, burst, state)
        return state

    def _words(self, seq: int) -> tuple[int, ...]:
        """A message's random words."""
        if self._hash is None:
            self._hash = hashlib.blake2b(key=self._key, digest_size=64)
        drawn = self._hash.copy()
        drawn.update(_SEQ.pack(seq))
        return _WORDS.unpack(drawn.digest())


def _uniform(word: int) -> float:
    """The number in [0, 1) that a random word makes."""
    return (word >> 11) * 2.0**-53


def _delay(fault: Fault, word: int) -> float:
    """Latency with jitter, never negative [s]."""
    if fault.jitter == 0.0:
        return fault.latency
    u = _uniform(word)
    if fault.distribution == "uniform":
        return max(0.0, fault.latency + fault.jitter * (2.0 * u - 1.0))
    if fault.distribution == "pareto":
        tail: float = (1.0 - u) ** (-1.0 / PARETO_SHAPE) - 1.0  # mean 1 / (shape - 1)
        return fault.latency + fault.jitter * (PARETO_SHAPE - 1.0) * tail
    normal = NormalDist(fault.latency, fault.jitter)
    below = normal.cdf(0.0)
    quantile = below + (1.0 - below) * u
    return max(0.0, normal.inv_cdf(quantile)) if 0.0 < quantile < 1.0 else 0.0


def damaged(payload: bytes, damage: float) -> bytes:
    """The payload with one to three bytes flipped; `damage` in [0, 1) says which and how."""
    data = bytearray(payload)
    bits = int(damage * 2**53)
    flips: dict[int, int] = {}  # by place, so that two flips of one byte cannot undo each other
    for n in range(1 + bits % 3):
        flips.setdefault((bits // (7 + 1000 * n)) % len(data), 1 + (bits >> (8 * n + 3)) % 255)
    for place, mask in flips.items():
        data[place] ^= mask
    return bytes(data)
