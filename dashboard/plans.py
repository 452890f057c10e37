"""The plans that a robot sent lately, to draw what it wants and what its neighbour still believes.

Plans come at up to a thousand a second and few of them are drawn, so that they are kept as bytes and decoded when
they are wanted. Only their size and their CRC are checked at once, lest damaged ones push good ones out.
"""

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass

from formation.errors import WireError
from network.codec import decode, unseal
from network.messages import Plan

KEPT_BYTES = 16 << 20
"""Memory for the plans of all robots."""
KEPT_PLANS = 1200
"""12 s at 100 Hz."""
PLAN_BYTES = 4096
"""No plan is larger: the longest horizon is 100 inputs of 16 bytes, and the rest of a plan is some 150."""
TRIES = 12
"""Plans looked at in search of one; they are numbered in steady steps, so that the first guess is mostly right."""


@dataclass(slots=True)
class _Entry:
    size: int
    payload: bytes | None
    """None once it was looked at."""
    plan: Plan | None = None
    """None before, and for good if it was not a plan of this robot's."""


class PlanLog:
    """One robot's plans. One thread adds while another looks."""

    def __init__(self, robot: int, robots: int, reject: Callable[[WireError], object] = lambda _: None) -> None:
        """Room for some seconds of plans of one of so many robots.

        Args:
            robot: whose plans.
            robots: how many robots share the memory.
            reject: told why, if a payload that `add` took turns out not to be a plan of this robot's.
        """
        self.robot = robot
        self._reject = reject
        self._room = KEPT_BYTES // max(1, robots)
        self._bytes = 0
        self._entries: deque[_Entry] = deque()
        self._found: Plan | None = None
        self._step: int | None = None

    def add(self, payload: bytes) -> None:
        """A payload came in.

        Raises:
            WireError: it is damaged, or larger than any plan.
        """
        if len(payload) > PLAN_BYTES:
            raise WireError(f"expected at most {PLAN_BYTES} bytes; got {len(payload)}")
        unseal(payload)
        self._entries.append(_Entry(len(payload), payload))
        self._bytes += len(payload)
        while self._bytes > self._room or len(self._entries) > KEPT_PLANS:
            self._bytes -= self._entries.popleft().size

    def newest(self) -> Plan | None:
        """The newest plan."""
        found = self._from(0)
        return None if found is None else found[1]

    def numbered(self, seq: int, epoch: int) -> Plan | None:
        """The plan of this number of this flight; None if it is not (or no longer) here."""
        if self._found is not None and (self._found.seq, self._found.epoch) == (seq, epoch):
            return self._found
        first = self._from(0)
        if first is None or first[1].epoch != epoch or seq > first[1].seq:
            return None
        back, newest = first
        step = self._step or self._look_for_step(back, newest)
        for _ in range(TRIES):
            here = self._from(back)
            if here is None or here[1].epoch != epoch:
                return None
            back, plan = here
            if plan.seq == seq:
                self._found = plan
                return plan
            move = (plan.seq - seq) // step
            back += move if move else (1 if plan.seq > seq else -1)
            if back < 0:
                return None
        return None

    def _look_for_step(self, back: int, newest: Plan) -> int:
        """Ticks from one plan to the next; looked up once, for a flight's are all the same."""
        before = self._from(back + 1)
        if before is None or before[1].seq >= newest.seq:
            return 1
        self._step = newest.seq - before[1].seq
        return self._step

    def _from(self, back: int) -> tuple[int, Plan] | None:
        """The first plan from so many entries before the newest on, backwards, and where it is."""
        while True:
            try:
                entry = self._entries[-1 - back]
            except IndexError:
                return None
            if entry.payload is not None:
                self._look(entry, entry.payload)
            if entry.plan is not None:
                return back, entry.plan
            back += 1

    def _look(self, entry: _Entry, payload: bytes) -> None:
        entry.payload = None
        try:
            plan = decode(Plan, payload)
            if plan.sender != self.robot:
                raise WireError(f"expected the sender named in the key; got {plan.sender}")
        except WireError as error:
            self._reject(error)
        else:
            entry.plan = plan
