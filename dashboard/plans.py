"""The plans that a robot sent lately, to draw what it wants and what its neighbour still believes.

Plans come at up to a thousand a second and few of them are drawn, so that they are kept as bytes and decoded when
they are wanted.
"""

from collections import deque
from dataclasses import dataclass

from formation.errors import WireError
from network.codec import decode
from network.messages import Plan

KEPT_BYTES = 16 << 20
"""Memory for the plans of all robots."""
KEPT_PLANS = 1200
"""12 s at 100 Hz."""
PLAN_BYTES = 600
"""About the size of one."""
TRIES = 12
"""Plans looked at in search of one; they are numbered in steady steps, so that the first guess is mostly right."""


@dataclass(slots=True)
class _Entry:
    payload: bytes
    plan: Plan | None = None


class PlanLog:
    """One robot's plans. One thread adds while another looks."""

    def __init__(self, robot: int, robots: int) -> None:
        """Room for some seconds of plans of one of so many robots."""
        self.robot = robot
        keep = min(KEPT_PLANS, KEPT_BYTES // (PLAN_BYTES * max(1, robots)))
        self._entries: deque[_Entry] = deque(maxlen=keep)
        self._found: Plan | None = None
        self.rejected = 0

    def add(self, payload: bytes) -> None:
        """A payload came in."""
        self._entries.append(_Entry(payload))

    def newest(self) -> Plan | None:
        """The newest plan."""
        return self._plan(0)

    def numbered(self, seq: int, epoch: int) -> Plan | None:
        """The plan of this number of this flight; None if it is not (or no longer) here."""
        if self._found is not None and (self._found.seq, self._found.epoch) == (seq, epoch):
            return self._found
        newest = self._plan(0)
        before = self._plan(1)
        if newest is None or newest.epoch != epoch or seq > newest.seq:
            return None
        step = max(1, newest.seq - before.seq) if before is not None else 1
        back = 0
        for _ in range(TRIES):
            plan = self._plan(back)
            if plan is None or plan.epoch != epoch:
                return None
            if plan.seq == seq:
                self._found = plan
                return plan
            move = (plan.seq - seq) // step
            back += move if move else (1 if plan.seq > seq else -1)
            if back < 0:
                return None
        return None

    def _plan(self, back: int) -> Plan | None:
        """The plan so many before the newest."""
        try:
            entry = self._entries[-1 - back]
        except IndexError:
            return None
        if entry.plan is None:
            try:
                plan = decode(Plan, entry.payload)
            except WireError:
                self.rejected += 1
                return None
            if plan.sender != self.robot:
                return None
            entry.plan, entry.payload = plan, b""
        return entry.plan
