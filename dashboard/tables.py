"""What the right panel says in tables: links, robots, events; and which faults are in force."""

from html import escape

import numpy as np

from dashboard import colours
from dashboard.feed import Seen
from dashboard.links import LinkView
from dashboard.palette import DARK, hue
from dashboard.summary import robot_word
from dashboard.words import FONT, LINE, MUTED, TABLE, arrow, duration, fault_words, length, light, remark
from network.messages import State, Status

MATRIX_ROBOTS = 8
"""With more robots the links stand in a list."""
NOTHING = "·"


def matrix(seen: Seen, views: list[LinkView]) -> str:
    """The links' ages: sender by row, receiver by column; a list if there are many."""
    if seen.state is None:
        return ""
    n = len(seen.state.poses)
    few = n <= MATRIX_ROBOTS
    note = "age of the newest plan" + (", sender row → receiver column" if few else "")
    title = f'<div style="padding:2px 0 4px"><b>Links</b> <span style="{MUTED}">{note}</span></div>'
    return f'<div style="{FONT};padding:0 16px 8px 10px">{title}{_square(n, views) if few else _list(views)}</div>'


def _list(views: list[LinkView]) -> str:
    cells = "".join(f'<div style="{_cell(v)}">{v.sender}→{v.receiver} {_cell_text(v)}</div>' for v in views)
    return f'<div style="display:grid;grid-template-columns:repeat(4,1fr);gap:2px">{cells}</div>'


def _square(n: int, views: list[LinkView]) -> str:
    by_pair = {(view.sender, view.receiver): view for view in views}
    numbers = range(1, n + 1)
    rows = "<tr><td></td>" + "".join(f'<td style="{MUTED};text-align:center">R{j}</td>' for j in numbers) + "</tr>"
    for i in numbers:
        dot = f'<span style="color:{hue(i, n)}">●</span>'
        rows += f'<tr><td style="font-weight:600;width:34px">{dot} R{i}</td>'
        for j in numbers:
            view = by_pair.get((i, j))
            rows += f'<td style="{_cell(view)}">{_cell_text(view) if view else ""}</td>'
        rows += "</tr>"
    return f'<table style="border-collapse:separate;border-spacing:2px;width:100%;table-layout:fixed">{rows}</table>'


def _cell(view: LinkView | None) -> str:
    if view is None:
        return "background:rgba(128,140,160,.07);height:20px"
    known = view.age is not None or view.cut
    colour = colours.css(colours.health(np.array(view.level))) if known else f"#{DARK.muted}"
    text = "color:#10151a;font-weight:700;text-align:center;white-space:nowrap;overflow:hidden"
    return f"background:{colour};{text};height:20px"


def _cell_text(view: LinkView) -> str:
    if view.age is None:
        return view.word
    number, unit = duration(view.age)
    text = f"{number} {unit}"
    if view.lost:
        text = f"{view.word} {text}"
    if view.loss >= 0.005 and not view.lost:
        text += f'<span style="font-weight:400"> -{100 * view.loss:.0f} %</span>'
    return text


_HEADS = ("", "state", "plan age", "solve", "missed", "l_e", "ψ_e", "gap", "pid")
_NOTE = (
    "plan age: of the newest plan from the robot upstream. solve: wall clock per plan. missed: ticks not answered in "
    "time. l_e, ψ_e: errors of the pair with the robot upstream. gap: what it could gain by changing its plan alone."
)


def robots(seen: Seen, views: list[LinkView]) -> str:
    """A row per robot: is it alive, how is it doing."""
    state = seen.state
    if state is None:
        return remark("No robots yet.")
    rows = _row("th", f"{MUTED};font-weight:500", _HEADS)
    for robot in range(1, len(state.poses) + 1):
        rows += _row("td", LINE, _robot(state, robot, seen.statuses.get(robot), views[robot - 2]))
    table = f'<table style="{TABLE}">{rows}</table>'
    return f'<div style="font-size:11px;line-height:1.3;padding:2px 6px">{table}<p style="{MUTED}">{_NOTE}</p></div>'


def _row(tag: str, style: str, cells: tuple[str, ...]) -> str:
    each = "text-align:right;padding:4px;white-space:nowrap"
    return f'<tr style="{style}">' + "".join(f'<{tag} style="{each}">{cell}</{tag}>' for cell in cells) + "</tr>"


def _robot(state: State, robot: int, status: Status | None, view: LinkView) -> tuple[str, ...]:
    word = robot_word(state, robot)
    own = (
        f'<span style="color:{hue(robot, len(state.poses))}">●</span>&nbsp;<b>R{robot}</b>',
        f'<span style="color:{light(0.0 if word == "OK" else 1.0)}">{"alive" if word == "OK" else word}</span>',
        NOTHING
        if view.age is None
        else f'<span style="color:{light(view.level)}">{" ".join(duration(view.age))}</span>',
    )
    errors = (
        " ".join(length(abs(float(state.distance_errors[robot - 1])))),
        f"{np.degrees(abs(float(state.angle_errors[robot - 1]))):.2f}°",
    )
    if status is None or status.epoch != state.epoch:
        return (*own, NOTHING, NOTHING, *errors, NOTHING, NOTHING)
    return (*own, f"{1e3 * status.solve:.2f} ms", str(status.missed), *errors, f"{status.gap:.0e}", str(status.pid))


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
        f"{arrow(link)}</b> {escape(fault_words(fault))}</div>"
        for link, fault in sorted(state.faults.items())
    )
    return f'<div style="{FONT};padding:0 10px 4px;max-height:84px;overflow-y:auto">{items}</div>'
