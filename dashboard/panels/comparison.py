"""The ghost in words: how the live flight does beside it."""

from collections.abc import Sequence
from html import escape

from dashboard.panels.summary import CARD
from dashboard.telemetry.ghost_track import COMPARED_SECONDS, FAR_BEHIND, Comparison, comparisons
from dashboard.telemetry.history import History
from dashboard.theme.formatting import FONT, MUTED, length
from network.messages import State

_GRID = "display:grid;grid-template-columns:repeat(4,auto);gap:2px 6px;font-size:11px;padding:6px 8px"
_GHOST = "color:var(--ghost)"


def comparison(state: State, history: History) -> str:
    """A line per error: live, ghost, and how much better the live one is; empty while nobody compares."""
    if not state.compare:
        return ""
    found = comparisons(history.series())
    if not found:
        return f'<div style="{FONT};{MUTED};padding:0 14px 6px 10px">{escape(_waiting(state, history))}</div>'
    head = (f"RMS, {COMPARED_SECONDS:.0f} s", state.controller, f"┅ {state.compare}")
    rows = _row(head, (MUTED, "text-align:right", f"grid-column:span 2;padding-left:10px;{_GHOST}"))
    rows += "".join(_verdict(verdict) for verdict in found)
    return f'<div style="padding:0 14px 8px 10px"><div style="{CARD};{_GRID}">{rows}</div></div>'


def _waiting(state: State, history: History) -> str:
    ghost = history.ghost.newest
    if ghost is not None and ghost.stamp < state.stamp - FAR_BEHIND:
        return f"The ghost flies after it from the start: {ghost.stamp:.0f} of {state.stamp:.0f} s."
    return "Waiting for the ghost."


def _verdict(verdict: Comparison) -> str:
    live, ghost = (" ".join(length(1e-3 * value)) for value in (verdict.live, verdict.ghost))
    tone = {"better": "ok", "worse": "bad"}.get(verdict.factor.split()[-1], "muted")
    tinted = f"text-align:right;color:var(--{tone});font-weight:700"
    styles = (MUTED, "text-align:right", f"text-align:right;{_GHOST}", tinted)
    return _row((verdict.name, live, ghost, verdict.factor), styles)


def _row(cells: Sequence[str], styles: Sequence[str]) -> str:
    return "".join(
        f'<span style="white-space:nowrap;{style}">{escape(cell)}</span>'
        for style, cell in zip(styles, cells, strict=True)
    )
