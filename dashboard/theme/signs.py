"""Signs of what happened, on the time line and in the ledger: each has its own form, so that no colour is needed."""

from typing import NamedTuple


class Sign(NamedTuple):
    """One sign."""

    form: str
    colour: str
    """Name of its colour in the style sheet."""
    meaning: str


SIGNS = {
    "fault": Sign("▲", "warn", "fault of a link"),
    "cut": Sign("✕", "bad", "link cut; in the ledger a lost agent too"),
    "lost": Sign("○", "bad", "agent lost"),
    "push": Sign("→", "ink", "robot pushed, slowed, stuck or blind"),
    "over": Sign("●", "ok", "end of it"),
    "unknown": Sign("?", "muted", "excursion without a known cause"),
}
"""By kind; those of telemetry/marks.py are among them."""
