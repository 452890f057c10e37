"""Marks on the time line: faults, cuts, lost agents, pushes, each with its span, from the states of an episode."""

from dataclasses import dataclass
from typing import Literal

from formation.faults import Fault
from formation.link_ids import LinkId
from network.messages import State
from network.values import Event

Kind = Literal["fault", "cut", "lost", "push"]
MOST = 300
"""Marks of an episode; the oldest are dropped."""
TOGETHER = 0.05
"""Marks of one kind that begin within this are one [s]."""
LONG = 28
"""Characters of a label, at most."""


@dataclass(slots=True)
class Mark:
    """Something that began at a time."""

    kind: Kind
    stamp: float
    """[s]."""
    names: list[str]
    """Of the links or robots that it is about."""
    what: str
    """In a word: "cut", "late"."""
    ends: float | None = None
    """When it was over [s]; None while it lasts, and of what has no span."""

    @property
    def label(self) -> str:
        """A few words."""
        if self.kind == "push":
            return self.what[:LONG]
        several = f"{len(self.names)} {'robots' if self.kind == 'lost' else 'links'}"
        return f"{self.names[0] if len(self.names) == 1 else several} {self.what}"


class Marks:
    """The marks of one episode."""

    def __init__(self) -> None:
        self.all: list[Mark] = []
        self._open: dict[str, Mark] = {}
        self._faults: dict[LinkId, Fault] = {}
        self._live: set[int] | None = None
        self._pushes: dict[tuple[int, str], Mark] = {}
        """Of the pushes that act now, by robot and what they do: the mark that was made of their event."""

    def take_event(self, event: Event) -> None:
        """An event that no state shows becomes a mark without a span."""
        if event.kind == "push" and "no longer" not in event.text:
            self.all.append(Mark("push", event.stamp, [], event.text))
            del self.all[:-MOST]

    def take_state(self, state: State) -> None:
        """Compare with the state before."""
        if state.faults != self._faults:
            for link in self._faults.keys() | state.faults.keys():
                before, now = self._faults.get(link), state.faults.get(link)
                if before != now:
                    self._close(f"link {link}", state.stamp)
                    if now is not None:
                        kind: Kind = "cut" if now.cut else "fault"
                        self._begin(f"link {link}", kind, state.stamp, str(link).replace("->", "→"), _word(now))
            self._faults = dict(state.faults)
        self._take_pushes(state)
        live = set(state.live)
        if self._live is not None and live != self._live:
            for robot in self._live - live:
                self._begin(f"robot {robot}", "lost", state.stamp, f"R{robot}", "lost")
            for robot in live - self._live:
                self._close(f"robot {robot}", state.stamp)
        self._live = live

    def _take_pushes(self, state: State) -> None:
        """Give the marks of pushes that are over their ends."""
        acting = {(one.robot, one.text) for one in state.pushes}
        for key in acting - self._pushes.keys():
            marks = [
                one for one in reversed(self.all) if one.kind == "push" and one.what.startswith(f"robot {key[0]}:")
            ]
            if marks and marks[0].ends is None:
                self._pushes[key] = marks[0]
        for key in self._pushes.keys() - acting:
            self._pushes.pop(key).ends = state.stamp

    def spans(self, now: float) -> list[tuple[float, float]]:
        """When faults and pushes acted: begin and end, `now` of those that still do [s]."""
        acting = {id(mark) for mark in (*self._open.values(), *self._pushes.values())}
        return [
            (one.stamp, now if one.ends is None else one.ends)
            for one in self.all
            if one.ends is not None or id(one) in acting
        ]

    def _begin(self, key: str, kind: Kind, stamp: float, name: str, what: str) -> None:
        last = self.all[-1] if self.all else None
        if (
            last is not None
            and (last.kind, last.what) == (kind, what)
            and stamp - last.stamp < TOGETHER
            and not last.ends
        ):
            last.names.append(name)
            mark = last
        else:
            mark = Mark(kind, stamp, [name], what)
            self.all.append(mark)
            del self.all[:-MOST]
        self._open[key] = mark

    def _close(self, key: str, stamp: float) -> None:
        mark = self._open.pop(key, None)
        if mark is not None:
            mark.ends = stamp


def _word(fault: Fault) -> str:
    if fault.cut:
        return "cut"
    if fault.latency > 0.0 or fault.jitter > 0.0:
        return "late"
    return "lossy" if fault.loss > 0.0 else "faulty"
