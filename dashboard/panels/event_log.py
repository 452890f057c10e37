"""The event log of the Log tab."""

from dashboard.theme.templates import render
from network.messages import Event, State

_COLOURS = {"run": "var(--r1)", "fault": "var(--warn)", "wire": "var(--warn)"}
"""CSS colours of the kinds of events; the other kinds are red."""
_GOOD = ("healthy", "is here", "moves again", "is back")


def event_log(state: State | None) -> str:
    """HTML of the newest events, the newest first."""
    return render("panels/event_log.html", state=state, colour_of=_colour)


def _colour(event: Event) -> str:
    good = any(part in event.text for part in _GOOD)
    return "var(--ok)" if good else _COLOURS.get(event.kind, "var(--bad)")
