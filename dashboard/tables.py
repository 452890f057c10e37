"""What the page says in words and numbers, as HTML. Every string that comes from elsewhere is escaped."""

from html import escape

import numpy as np

from dashboard import colours
from dashboard.feed import Seen
from dashboard.layers import DISTANCE_LIMIT
from dashboard.links import LOST_SECONDS, LinkView, oldest
from network.messages import State

TRACKING_LIMIT = 0.025
"""[m]"""
MATRIX_ROBOTS = 8
"""With more robots the links stand in a list."""

_MUTED = "color:#8b94a5"
_FONT = "font-size:12px;line-height:1.35"
_CARD = "background:rgba(128,140,160,.10);border-radius:4px"


def head(seen: Seen, views: list[LinkView]) -> str:
    """Status, time, the three figures that matter, a chip per robot."""
    word, colour, note = condition(seen)
    state = seen.state
    pill = (
        f'<span style="background:{colour};color:#0b1210;font-weight:700;border-radius:12px;padding:3px 10px;'
        f'font-size:11px;letter-spacing:.03em">{word}</span>'
    )
    if state is None:
        return (
            f'<div style="{_FONT};padding:4px 10px">{pill}<p style="{_MUTED};margin:8px 0 0">{escape(note)}</p></div>'
        )
    pace = f"{state.pace:.2g}x · " if state.status == "running" and seen.here else ""
    line = (
        f'<div style="display:flex;align-items:center;gap:8px;white-space:nowrap">{pill}'
        f'<span style="font-size:13px">t = {state.stamp:.1f} s</span>'
        f'<span style="{_MUTED};margin-left:auto;font-size:11px">{pace}{len(state.poses)} robots</span></div>'
    )
    more = f'<div style="{_MUTED};margin-top:6px">{escape(note)}</div>' if note else ""
    return f'<div style="{_FONT};padding:4px 10px 10px">{line}{more}{_tiles(state, views)}{_chips(seen, views)}</div>'


def condition(seen: Seen) -> tuple[str, str, str]:
    """A word for how the run is, its colour, and a sentence if there is something to say."""
    state = seen.state
    green, amber, red, grey = (f"#{c}" for c in (colours.OK, colours.WARN, colours.BAD, colours.GREY))
    if not seen.connected:
        return "NO ROUTER", red, "The run's router is gone. This page comes back by itself when it does."
    if state is None:
        return "WAITING", amber, "Waiting for the world of this run to speak."
    if not seen.here:
        return "NO WORLD", red, "The world has stopped speaking; what is shown is its last word. Waiting for it."
    if state.status == "waiting":
        names = ", ".join(str(robot) for robot in state.waiting_for) or "…"
        return "WAITING", amber, f"Waiting for the agents of robots {names}."
    if state.status == "finished":
        return "FINISHED", grey, "The flight is over. Fly again starts it anew."
    note = ""
    if state.waiting_for:
        note = "No agent for robots " + ", ".join(map(str, state.waiting_for)) + ": they stand still."
    return ("RUNNING", green, note) if state.status == "running" else ("PAUSED", amber, note)


def _tiles(state: State, views: list[LinkView]) -> str:
    distance = float(abs(state.distance_errors).max())
    age = oldest(views)
    tiles = (
        ("DIST ERR", *_length(distance), distance / DISTANCE_LIMIT),
        ("TRACK", *_length(state.tracking_error), state.tracking_error / TRACKING_LIMIT),
        ("OLDEST PLAN", *_time(age), age / LOST_SECONDS),
    )
    cells = "".join(
        f'<div style="{_CARD};border-left:3px solid {_light(level)};padding:5px 8px;min-width:0">'
        f'<div style="{_MUTED};font-size:10px;letter-spacing:.04em;white-space:nowrap">{label}</div>'
        f'<div style="font-size:17px;font-weight:700;white-space:nowrap">{number}'
        f'<span style="{_MUTED};font-size:11px;font-weight:400"> {unit}</span></div></div>'
        for label, number, unit, level in tiles
    )
    return f'<div style="display:grid;grid-template-columns:1fr 1fr 1fr;gap:6px;margin-top:8px">{cells}</div>'


def _chips(seen: Seen, views: list[LinkView]) -> str:
    state = seen.state
    assert state is not None
    n = len(state.poses)
    chips = ""
    for robot in range(1, n + 1):
        word = robot_word(state, robot)
        level = 1.0 if word != "OK" else views[robot - 2].level
        hue = colours.identity(robot, n)
        name = f"R{robot}" if word == "OK" else f"R{robot} {word}"
        chips += (
            f'<span style="{_CARD};border-bottom:2px solid {_light(level)};padding:2px 6px;flex:1 0 auto;text-align:center;'
            f'white-space:nowrap"><span style="color:#{hue}">●</span> {name}</span>'
        )
    return f'<div style="display:flex;flex-wrap:wrap;gap:4px;margin-top:6px;font-size:11px">{chips}</div>'


def robot_word(state: State, robot: int) -> str:
    """How a robot is, in a word."""
    if robot not in state.live:
        return "LOST"
    return "HELD" if robot in state.stopped else "OK"


def matrix(seen: Seen, views: list[LinkView]) -> str:
    """The links' ages: sender by row, receiver by column; a list if there are many."""
    if seen.state is None:
        return ""
    n = len(seen.state.poses)
    title = (
        f'<div style="padding:2px 0 4px"><b>Links</b> <span style="{_MUTED}">age of the newest plan'
        + (", sender row → receiver column" if n <= MATRIX_ROBOTS else "")
        + "</span></div>"
    )
    if n > MATRIX_ROBOTS:
        cells = "".join(
            f'<div style="{_cell(view)}">{view.sender}→{view.receiver} {_cell_text(view)}</div>' for view in views
        )
        body = f'<div style="display:grid;grid-template-columns:repeat(4,1fr);gap:2px">{cells}</div>'
        return f'<div style="{_FONT};padding:0 10px 8px">{title}{body}</div>'
    by_pair = {(view.sender, view.receiver): view for view in views}
    rows = (
        "<tr><td></td>"
        + "".join(f'<td style="{_MUTED};text-align:center">R{j}</td>' for j in range(1, n + 1))
        + "</tr>"
    )
    for i in range(1, n + 1):
        rows += f'<tr><td style="font-weight:600;width:34px"><span style="color:#{colours.identity(i, n)}">●</span> R{i}</td>'
        for j in range(1, n + 1):
            view = by_pair.get((i, j))
            rows += f'<td style="{_cell(view)}">{_cell_text(view) if view else ""}</td>'
        rows += "</tr>"
    table = f'<table style="border-collapse:separate;border-spacing:2px;width:100%;table-layout:fixed">{rows}</table>'
    return f'<div style="{_FONT};padding:0 10px 8px">{title}{table}</div>'


def _cell(view: LinkView | None) -> str:
    if view is None:
        return "background:rgba(128,140,160,.07);height:20px"
    colour = (
        colours.css(colours.health(np.array(view.level))) if view.age is not None or view.cut else f"#{colours.GREY}"
    )
    return f"background:{colour};color:#10151a;font-weight:700;text-align:center;height:20px;white-space:nowrap;overflow:hidden"


def _cell_text(view: LinkView) -> str:
    if view.age is None:
        return view.word
    number, unit = _time(view.age)
    text = f"{number} {unit}"
    if view.lost:
        text = f"{view.word} {text}"
    if view.loss >= 0.005 and not view.lost:
        text += f'<span style="font-weight:400"> -{100 * view.loss:.0f} %</span>'
    return text


def robots(seen: Seen, views: list[LinkView]) -> str:
    """A row per robot: is it alive, how is it doing."""
    state = seen.state
    if state is None:
        return _empty("No robots yet.")
    n = len(state.poses)
    heads = ("", "state", "plan age", "solve", "missed", "l_e", "ψ_e", "gap", "pid")
    rows = "<tr>" + "".join(
        f'<th style="{_MUTED};font-weight:500;text-align:right;padding:3px 4px">{h}</th>' for h in heads
    )
    for robot in range(1, n + 1):
        status, word, view = seen.statuses.get(robot), robot_word(state, robot), views[robot - 2]
        said = status is not None and status.epoch == state.epoch
        cells = [
            f'<span style="color:#{colours.identity(robot, n)}">●</span>&nbsp;<b>R{robot}</b>',
            f'<span style="color:{_light(0.0 if word == "OK" else 1.0)}">{"alive" if word == "OK" else word}</span>',
            f'<span style="color:{_light(view.level)}">{" ".join(_time(view.age))}</span>'
            if view.age is not None
            else "–",
            f"{1e3 * status.solve:.2f} ms" if status is not None and said else "–",
            str(status.missed) if status is not None and said else "–",
            " ".join(_length(abs(float(state.distance_errors[robot - 1])))),
            f"{abs(float(state.angle_errors[robot - 1])) * 57.29578:.2f}°",
            f"{status.gap:.1e}" if status is not None and said else "–",
            str(status.pid) if status is not None and said else "–",
        ]
        rows += '<tr style="border-top:1px solid rgba(128,140,160,.15)">' + "".join(
            f'<td style="text-align:right;padding:4px 4px;white-space:nowrap">{cell}</td>' for cell in cells
        )
    note = (
        "plan age: of the newest plan from the robot upstream · solve: wall clock per plan · missed: ticks not answered in "
        "time · l_e, ψ_e: errors of the pair with the robot upstream · gap: what it could gain by changing its plan alone"
    )
    return (
        f'<div style="font-size:11px;line-height:1.3;padding:2px 6px"><table style="width:100%;border-collapse:collapse">{rows}</table>'
        f'<p style="{_MUTED};margin:8px 4px">{note}</p></div>'
    )


def log(state: State | None) -> str:
    """The newest events, the newest first."""
    if state is None or not state.events:
        return _empty("Nothing has happened yet.")
    tints = {
        "run": colours.IDENTITY[0],
        "fault": colours.WARN,
        "agent": colours.BAD,
        "watchdog": colours.BAD,
        "wire": colours.WARN,
    }
    rows = ""
    for event in reversed(state.events):
        good = (
            (event.kind == "fault" and "healthy" in event.text) or "is here" in event.text or "moves again" in event.text
        )
        tint = colours.OK if good else tints[event.kind]
        rows += (
            f'<tr style="border-top:1px solid rgba(128,140,160,.15);vertical-align:top">'
            f'<td style="{_MUTED};text-align:right;padding:3px 8px 3px 0;white-space:nowrap">{event.stamp:.2f} s</td>'
            f'<td style="color:#{tint};padding:3px 8px 3px 0">{escape(event.kind)}</td>'
            f'<td style="padding:3px 0;overflow-wrap:anywhere">{_arrow(event.text)}</td></tr>'
        )
    counted = f"{state.rejected} payloads refused · {state.overruns} late ticks"
    return (
        f'<div style="{_FONT};padding:2px 10px"><table style="width:100%;border-collapse:collapse">{rows}</table>'
        f'<p style="{_MUTED};margin:8px 0">{counted}</p></div>'
    )


def in_force(state: State | None) -> str:
    """Which faults the world has on now."""
    if state is None or not state.faults:
        return f'<div style="{_FONT};{_MUTED};padding:0 10px 4px">No faults: every link is perfect.</div>'
    items = "".join(
        f'<div style="overflow-wrap:anywhere"><b style="color:#{colours.BAD if fault.get("cut") else colours.WARN}">'
        f"{_arrow(link)}</b> {escape(fault_words(fault))}</div>"
        for link, fault in sorted(state.faults.items())
    )
    return f'<div style="{_FONT};padding:0 10px 4px;max-height:84px;overflow-y:auto">{items}</div>'


def fault_words(fault: dict[str, object]) -> str:
    """A fault in a few words."""
    if fault.get("cut"):
        return "cut"
    words = []
    for key, value in fault.items():
        if isinstance(value, bool) or not isinstance(value, int | float):
            words.append(key.replace("_", " ") if value is True else f"{value}")
        elif key in ("latency", "jitter"):
            words.append(f"{key} {1e3 * value:.4g} ms")
        elif key in ("loss", "duplicate", "reorder", "corrupt"):
            words.append(f"{key} {100 * value:.3g} %")
        else:
            words.append(f"{key} {value:.4g}")
    return ", ".join(words)


def legend() -> str:
    """What the lines mean."""
    ramp = f"linear-gradient(90deg,#{colours.OK},#{colours.WARN},#{colours.BAD})"
    rows = (
        ('<span style="border-top:3px solid #56b4e9;width:28px"></span>', "own plan, two seconds ahead"),
        (
            '<span style="border-top:2px dashed #56b4e9;width:28px"></span>',
            "that plan as its neighbour still believes it",
        ),
        (
            f'<span style="border:2px solid #{colours.GREY};border-radius:50%;width:11px;height:11px"></span>',
            "where it should be",
        ),
        (
            f'<span style="background:{ramp};height:5px;width:28px;border-radius:2px"></span>',
            "edge: error 0…20 mm, arrow: age 0…500 ms",
        ),
        (f'<span style="border-top:2px dashed #{colours.BAD};width:28px"></span>', "no plan for half a second: lost"),
    )
    lines = "".join(
        f'<div style="display:flex;align-items:center;gap:10px;margin:3px 0"><span style="width:30px;display:flex;'
        f'justify-content:center;flex:none">{mark}</span><span>{text}</span></div>'
        for mark, text in rows
    )
    return f'<div style="font-size:11px;padding:0 10px 6px">{lines}</div>'


def plot_title(name: str, unit: str, marks: tuple[tuple[str, str], ...]) -> str:
    """The line above a plot."""
    series = "".join(f'<span style="color:{colour};margin-left:10px">● {text}</span>' for text, colour in marks)
    return (
        f'<div style="display:flex;font-size:12px;padding:0 10px;margin-bottom:-8px"><b>{name}</b><span style="{_MUTED};margin-left:8px">'
        f'{unit}</span><span style="margin-left:auto;font-size:11px">{series}</span></div>'
    )


def _arrow(text: str) -> str:
    """Escaped text in which links have a proper arrow."""
    return escape(text).replace("-&gt;", "→")


def _empty(text: str) -> str:
    return f'<div style="{_FONT};{_MUTED};padding:8px 10px">{escape(text)}</div>'


def _light(level: float) -> str:
    return f"#{colours.OK}" if level < 0.5 else f"#{colours.WARN}" if level < 1.0 else f"#{colours.BAD}"


def _length(metres: float) -> tuple[str, str]:
    mm = 1e3 * metres
    if mm < 0.0995:
        return f"{1e3 * mm:.0f}", "µm"
    return (f"{mm:.2f}" if mm < 9.995 else f"{mm:.1f}" if mm < 99.95 else f"{mm:.0f}"), "mm"


def _time(seconds: float) -> tuple[str, str]:
    return (f"{1e3 * seconds:.0f}", "ms") if seconds < 0.9995 else (f"{seconds:.1f}", "s")
