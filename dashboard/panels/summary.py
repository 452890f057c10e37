"""The head of the left panel: how the run is, in a word, three figures and a chip per robot."""

from html import escape

from dashboard.telemetry.links import LOST_SECONDS, LinkView, oldest
from dashboard.telemetry.subscriber import Snapshot
from dashboard.theme.formatting import FONT, MUTED, duration, length, light
from dashboard.theme.limits import DISTANCE_LIMIT, TRACKING_LIMIT, WAITS_SECONDS
from dashboard.theme.palette import DARK, hue
from network.messages import State, Status

CARD = "background:rgba(128,140,160,.10);border-radius:4px"


def head(snapshot: Snapshot, views: list[LinkView]) -> str:
    """Status, time, the three figures that matter, a chip per robot."""
    word, colour, note = condition(snapshot)
    state = snapshot.state
    pill = (
        f'<span style="background:{colour};color:#0b1210;font-weight:700;border-radius:12px;padding:3px 10px;'
        f'font-size:11px;letter-spacing:.03em">{word}</span>'
    )
    if state is None:
        return f'<div style="{FONT};padding:4px 10px">{pill}<p style="{MUTED};margin:8px 0 0">{escape(note)}</p></div>'
    pace = f"{state.pace:.2g}x · " if state.status == "running" and snapshot.world_alive else ""
    line = (
        f'<div style="display:flex;align-items:center;gap:8px;white-space:nowrap">{pill}'
        f'<span style="font-size:13px">t = {state.stamp:.1f} s</span>'
        f'<span style="{MUTED};margin-left:auto;font-size:11px">{pace}{len(state.poses)} robots</span></div>'
    )
    more = f'<div style="{MUTED};margin-top:6px">{escape(note)}</div>' if note else ""
    body = line + more + _tiles(state, views) + _chips(snapshot, views)
    return f'<div style="{FONT};padding:4px 14px 10px 10px">{body}</div>'


def condition(snapshot: Snapshot) -> tuple[str, str, str]:
    """A word for how the run is, its colour, and a sentence if there is something to say."""
    state = snapshot.state
    green, amber, red, grey = (f"#{c}" for c in (DARK.ok, DARK.warn, DARK.bad, DARK.muted))
    if not snapshot.connected:
        return "NO ROUTER", red, "The run's router is gone. This page comes back by itself when it does."
    if state is None:
        return "WAITING", amber, "Waiting for the world of this run to speak."
    if not snapshot.world_alive:
        return "NO WORLD", red, "The world has stopped speaking; what is shown is its last word. Waiting for it."
    if state.status == "waiting":
        names = ", ".join(str(robot) for robot in state.waiting_for) or "…"
        return "WAITING", amber, f"Waiting for the agents of robots {names}."
    if state.status == "finished":
        return "FINISHED", grey, "The flight is over. Fly again starts it anew."
    note, behind = "", max((lag(status, state) for status in snapshot.statuses.values()), default=0.0)
    if behind > WAITS_SECONDS:
        number, unit = duration(behind)
        note = f"The robots wait for one another, {number} {unit} behind the clock; the rings are where it wants them."
    if state.waiting_for:
        note = "No agent for robots " + ", ".join(map(str, state.waiting_for)) + ": they stand still."
    return ("RUNNING", green, note) if state.status == "running" else ("PAUSED", amber, note)


def lag(status: Status | None, state: State) -> float:
    """How far a robot is behind the clock by its own account [s]; 0 if it has not said."""
    plan = status.plan if status is not None else None
    return plan.lag if plan is not None and plan.episode == state.episode else 0.0


def _tiles(state: State, views: list[LinkView]) -> str:
    distance = float(abs(state.distance_errors).max())
    age = oldest(views)
    tiles = (
        ("DIST ERR", *length(distance), distance / DISTANCE_LIMIT),
        ("TRACK", *length(state.tracking_error), state.tracking_error / TRACKING_LIMIT),
        ("OLDEST PLAN", *duration(age), age / LOST_SECONDS),
    )
    cells = "".join(
        f'<div style="{CARD};border-left:3px solid {light(level)};padding:5px 8px;min-width:0">'
        f'<div style="{MUTED};font-size:10px;letter-spacing:.04em;white-space:nowrap">{label}</div>'
        f'<div style="font-size:17px;font-weight:700;white-space:nowrap">{number}'
        f'<span style="{MUTED};font-size:11px;font-weight:400"> {unit}</span></div></div>'
        for label, number, unit, level in tiles
    )
    return f'<div style="display:grid;grid-template-columns:1fr 1fr 1fr;gap:6px;margin-top:8px">{cells}</div>'


def _chips(snapshot: Snapshot, views: list[LinkView]) -> str:
    state = snapshot.state
    assert state is not None
    n = len(state.poses)
    chips = ""
    grid = "display:grid;grid-template-columns:repeat(auto-fit,minmax(58px,1fr))"
    for robot in range(1, n + 1):
        word = robot_label(state, robot)
        level = 1.0 if word != "OK" else views[robot - 2].level
        name = f"R{robot}" if word == "OK" else f"R{robot} {word}"
        chips += (
            f'<span style="{CARD};border-bottom:2px solid {light(level)};padding:2px 4px;'
            f'text-align:center;white-space:nowrap"><span style="color:{hue(robot, n)}">●</span> {name}</span>'
        )
    return f'<div style="{grid};gap:4px;margin-top:6px;font-size:11px">{chips}</div>'


def robot_label(state: State, robot: int) -> str:
    """How a robot is, in a word."""
    if robot not in state.live:
        return "KILLED" if robot in state.dismissed else "LOST"
    return "HELD" if robot in state.stopped else "OK"
