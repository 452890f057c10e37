"""What the right panel says in tables: robots, events; and which faults are in force."""

from html import escape

from dashboard.panels.clickable import Clickable
from dashboard.panels.summary import lag, robot_label
from dashboard.telemetry.links import LinkView
from dashboard.telemetry.subscriber import Snapshot
from dashboard.theme.formatting import FONT, LINE, MUTED, TABLE, arrow, duration, fault_text, length, light, remark
from dashboard.theme.limits import WAITS_SECONDS
from dashboard.theme.palette import hue
from network.messages import State, Status

NOTHING = "·"


_HEADS = ("", "agent", "age", "solve", "missed", "error", "gap", "")
_NOTE = (
    "agent: how it is, or how far behind the clock because robots wait for one another. age: of the newest plan from "
    "the robot upstream. solve: wall clock per plan [ms]. missed: ticks not answered in time. error: of the distance "
    "to the robot upstream. gap: what it could gain by changing its plan alone. Press a robot to follow it; kill its "
    "agent and see what the others do."
)


def robots(snapshot: Snapshot, views: list[LinkView], clickable: Clickable) -> str:
    """A row per robot: is it alive, how is it doing; to be followed, killed and restarted at a press."""
    state = snapshot.state
    if state is None:
        return remark("No robots yet.")
    rows = _row("th", f"{MUTED};font-weight:500", _HEADS)
    for robot in range(1, len(state.poses) + 1):
        cells = _robot(state, robot, snapshot.statuses.get(robot), views[robot - 2])
        name = f'<span {clickable.tap("focus", robot)} title="Follow robot {robot}">{cells[0]}</span>'
        rows += _row("td", LINE, (name, *cells[1:], _orders(state, robot, clickable)))
    table = clickable.around(f'<table style="{TABLE}">{rows}</table>')
    return f'<div style="font-size:11px;line-height:1.3;padding:2px 6px">{table}<p style="{MUTED}">{_NOTE}</p></div>'


def _row(tag: str, style: str, cells: tuple[str, ...]) -> str:
    each = "text-align:right;padding:4px 2px;white-space:nowrap"
    return f'<tr style="{style}">' + "".join(f'<{tag} style="{each}">{cell}</{tag}>' for cell in cells) + "</tr>"


def _orders(state: State, robot: int, clickable: Clickable) -> str:
    """What can be done with a robot's agent now."""
    down = robot in state.dismissed
    offered = [("restart", "ok")] if down else [("kill", "bad"), ("restart", "muted")]
    look = "border:1px solid;border-radius:3px;padding:0 3px;margin-left:2px;display:inline-block"
    return "".join(
        f'<span {clickable.tap(verb, robot)} style="{look};color:var(--{colour})">{verb}</span>'
        for verb, colour in offered
    )


def _robot(state: State, robot: int, status: Status | None, view: LinkView) -> tuple[str, ...]:
    word = robot_label(state, robot)
    fresh = status if status is not None and status.episode == state.episode else None
    pid = f"process {fresh.pid}" if fresh is not None and robot in state.live else "no process"
    level, behind = 0.0 if word == "OK" else 1.0, lag(fresh, state)
    if word == "OK" and behind > WAITS_SECONDS:
        level, word = 0.5, f"−{' '.join(duration(behind))}"
    own = (
        f'<span style="color:{hue(robot, len(state.poses))}">●</span>&nbsp;<b>R{robot}</b>',
        f'<span title="{pid}" style="color:{light(level)}">{"alive" if word == "OK" else word}</span>',
        NOTHING
        if view.age is None
        else f'<span style="color:{light(view.level)}">{" ".join(duration(view.age))}</span>',
    )
    error = " ".join(length(abs(float(state.distance_errors[robot - 1]))))
    if fresh is None:
        return (*own, NOTHING, NOTHING, error, NOTHING)
    return (*own, f"{1e3 * fresh.solve:.2f}", str(fresh.missed), error, f"{fresh.gap:.0e}")


_TINTS = {"run": "var(--r1)", "fault": "var(--warn)", "wire": "var(--warn)"}
_GOOD = ("healthy", "is here", "moves again", "is back")


def log(state: State | None) -> str:
    """The newest events, the newest first."""
    if state is None or not state.events:
        return remark("Nothing has happened yet.")
    rows = ""
    for event in reversed(state.events):
        good = any(word in event.text for word in _GOOD)
        tint = "var(--ok)" if good else _TINTS.get(event.kind, "var(--bad)")
        rows += (
            f'<tr style="{LINE};vertical-align:top">'
            f'<td style="{MUTED};text-align:right;padding:3px 8px 3px 0;white-space:nowrap">{event.stamp:.2f} s</td>'
            f'<td style="color:{tint};padding:3px 8px 3px 0">{escape(event.kind)}</td>'
            f'<td style="padding:3px 0;overflow-wrap:anywhere">{arrow(event.text)}</td></tr>'
        )
    counted = f"{state.rejected} payloads refused, {state.overruns} late ticks"
    return f'<div style="{FONT};padding:2px 10px"><table style="{TABLE}">{rows}</table></div>{remark(counted)}'


def in_force(state: State | None) -> str:
    """Which faults the world has on now."""
    if state is None or not state.faults:
        return f'<div style="{FONT};{MUTED};padding:0 10px 4px">No faults: every link is perfect.</div>'
    items = "".join(
        f'<div style="overflow-wrap:anywhere"><b style="color:var(--{"bad" if fault.get("cut") else "warn"})">'
        f"{arrow(link)}</b> {escape(fault_text(fault))}</div>"
        for link, fault in sorted(state.faults.items())
    )
    return f'<div style="{FONT};padding:0 10px 4px;max-height:84px;overflow-y:auto">{items}</div>'
