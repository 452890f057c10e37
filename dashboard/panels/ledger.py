"""The Ledger tab: every excursion with its likely cause; a pressed row goes to that moment on the time line."""

from typing import NamedTuple

from dashboard.panels.clickable import Clickable
from dashboard.telemetry.playhead import Playhead
from dashboard.telemetry.snapshot import Snapshot
from dashboard.theme.palette import hue
from dashboard.theme.signs import SIGNS, Sign
from dashboard.theme.templates import render
from network.messages import State
from network.values import Excursion

VERB = "excursion"
ROWS = 32
"""Numbers that a pressed row can have: those of excursions repeat after so many; fewer are shown."""
BEFORE = 0.5
"""A pressed row goes to so long before the excursion, or its cause [s]."""


class _Row(NamedTuple):
    """An excursion as the table has it."""

    one: Excursion
    hue: str
    """Of its robot."""
    sign: Sign
    """What kind of cause: a fault, a push, an agent, or none."""
    click: int
    chosen: bool


class LedgerTab:
    """What is known of the ledger, and which row is chosen."""

    def __init__(self, playhead: Playhead) -> None:
        self._playhead = playhead
        self._state: State | None = None
        self._chosen: tuple[int, int] | None = None
        """Episode, and number of the excursion."""

    def html(self, snapshot: Snapshot, clickable: Clickable) -> str:
        """The table of the run's newest excursions, the newest first, and how the chosen one came about."""
        state = self._state = snapshot.state
        shown = [] if state is None else state.excursions
        chosen = next((one for one in shown if state and (state.episode, one.number) == self._chosen), None)
        n = 0 if state is None else len(state.poses)
        rows = [_row(one, n, chosen=one is chosen) for one in reversed(shown)]
        return render(
            "panels/ledger.html",
            state=state,
            noise=snapshot.noise,
            rows=rows,
            chosen=chosen,
            clickable=clickable,
            verb=VERB,
        )

    def press(self, click: int) -> None:
        """A row was pressed: show the moment just before."""
        state = self._state
        found = next((one for one in state.excursions if one.number % ROWS == click), None) if state else None
        if state is None or found is None:
            return
        self._chosen = state.episode, found.number
        begins = found.at if found.cause_at is None else max(found.cause_at, found.at - 5.0)
        self._playhead.go_in_run(state.episode, max(0.0, begins - BEFORE))

    @property
    def span(self) -> tuple[float, float] | None:
        """Begin and end of the chosen excursion [s]; None without one."""
        state = self._state
        if state is None or self._chosen is None or state.episode != self._chosen[0]:
            return None
        found = next((one for one in state.excursions if one.number == self._chosen[1]), None)
        return None if found is None else (found.at, state.stamp if found.until is None else found.until)

    @staticmethod
    def verbs(state: State | None) -> dict[str, int]:
        """What Clickable has to take."""
        return {VERB: ROWS - 1} if state is not None and state.excursions else {}


def _row(one: Excursion, robots: int, *, chosen: bool) -> _Row:
    if one.cause_at is None:
        kind = "unknown"
    elif "cut" in one.cause or "gone" in one.cause:
        kind = "cut"
    elif one.cause.startswith("robot "):
        kind = "push"
    else:
        kind = "fault"
    return _Row(one, hue(one.robot, robots), SIGNS[kind], one.number % ROWS, chosen)
