"""The run against the ghost in numbers, below the choice of the controller to compare with."""

from collections.abc import Mapping

from dashboard.telemetry.ghost_track import FAR_BEHIND, comparisons
from dashboard.telemetry.history import History
from dashboard.theme.templates import render
from formation.arrays import FloatArray
from network.messages import State

_COLOURS = {"better": "ok", "worse": "bad"}


def comparison(state: State, history: History, series: Mapping[str, FloatArray], seconds: float) -> str:
    """HTML of a row per error: the run's, the ghost's, and their ratio; empty while no ghost is asked for.

    Args:
        state: of the moment.
        history: that tells why there are no numbers.
        series: columns with the errors of both.
        seconds: that are compared, up to the last of them [s].
    """
    if not state.compare:
        return ""
    rows = comparisons(series, seconds)
    colours = [_COLOURS.get(row.factor.split()[-1], "muted") for row in rows]
    return render(
        "panels/comparison.html",
        state=state,
        rows=list(zip(rows, colours, strict=True)),
        seconds=seconds,
        note=_note(state, history),
    )


def _note(state: State, history: History) -> str:
    """Why there are no numbers yet."""
    ghost = history.ghost.newest
    if ghost is not None and ghost.stamp < state.stamp - FAR_BEHIND:
        return f"The ghost catches up from the start: {ghost.stamp:.0f} of {state.stamp:.0f} s."
    return "Waiting for the ghost."
