"""The event log of the Log tab."""

from dashboard.theme.templates import render
from network.messages import State
from network.values import Event

_COLOURS = {"info": "var(--ok)", "warning": "var(--warn)", "error": "var(--bad)"}
"""CSS colours by severity."""


def event_log(state: State | None) -> str:
    """HTML of the newest events, the newest first."""
    return render("panels/event_log.html", state=state, colour_of=_colour)


def _colour(event: Event) -> str:
    return "var(--r1)" if (event.kind, event.severity) == ("run", "info") else _COLOURS[event.severity]
