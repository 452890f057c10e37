"""The link matrix: how old the newest plan over every link is, and which links are the target of faults."""

from collections.abc import Collection

from dashboard.panels.clickable import Clickable
from dashboard.telemetry.links import LinkView
from dashboard.telemetry.subscriber import Snapshot
from dashboard.theme import colours
from dashboard.theme.formatting import FONT, MUTED, duration
from dashboard.theme.palette import DARK, hue
from formation.pattern import downstream, upstream

MATRIX_ROBOTS = 8
"""With more robots the links stand in a list."""
_CHOSEN = "outline:2px solid var(--r1);outline-offset:0"


def matrix(snapshot: Snapshot, views: list[LinkView], click: Clickable, chosen: Collection[str]) -> str:
    """The links' ages: sender by row, receiver by column; a list if there are many.

    A press on a cell chooses that link as the target of faults, on a robot its both links, on the corner all.

    Args:
        seen, views: what is known.
        taps: takes "link" with a sender, "both" with a robot, "all" with 0.
        chosen: names of the links that are the target now; "all" for all of the ring's.
    """
    if snapshot.state is None:
        return ""
    n = len(snapshot.state.poses)
    few = n <= MATRIX_ROBOTS
    note = "row to column; " * few + "press one to aim faults at it"
    title = f'<div style="padding:2px 0 4px"><b>Age of plans</b> <span style="{MUTED}">{note}</span></div>'
    body = _square(n, views, click, chosen) if few else _list(views, click, chosen)
    return click.around(f'<div style="{FONT};padding:0 16px 8px 10px">{title}{body}</div>')


def _list(views: list[LinkView], click: Clickable, chosen: Collection[str]) -> str:
    cells = "".join(
        f'<div {click.tap("link", view.sender)} style="{_cell(view)};{_marked(view, chosen)}">'
        f"{view.sender}→{view.receiver} {_cell_text(view)}</div>"
        for view in views
    )
    return f'<div style="display:grid;grid-template-columns:repeat(4,1fr);gap:3px">{cells}</div>'


def _square(n: int, views: list[LinkView], click: Clickable, chosen: Collection[str]) -> str:
    by_pair = {(view.sender, view.receiver): view for view in views}
    numbers = range(1, n + 1)
    mark = _CHOSEN if "all" in chosen else ""
    rows = (
        f'<tr><td {click.tap("all", 0)} title="All links" style="{MUTED};{mark};text-align:center;width:44px">all</td>'
    )
    rows += "".join(f'<td style="{MUTED};text-align:center">R{j}</td>' for j in numbers) + "</tr>"
    for i in numbers:
        dot = f'<span style="color:{hue(i, n)}">●</span>'
        both = {f"{upstream(i, n)}->{i}", f"{i}->{downstream(i, n)}"}
        mark = _CHOSEN if n > 2 and both == set(chosen) else ""
        hint = f'title="Both links of robot {i}"'
        rows += (
            f'<tr><td {click.tap("both", i)} {hint} style="font-weight:600;white-space:nowrap;{mark}">{dot} R{i}</td>'
        )
        for j in numbers:
            view = by_pair.get((i, j))
            if view is None:
                rows += f'<td style="{_cell(view)}"></td>'
            else:
                rows += (
                    f'<td {click.tap("link", i)} style="{_cell(view)};{_marked(view, chosen)}">{_cell_text(view)}</td>'
                )
        rows += "</tr>"
    return f'<table style="border-collapse:separate;border-spacing:3px;width:100%;table-layout:fixed">{rows}</table>'


def _marked(view: LinkView, chosen: Collection[str]) -> str:
    return _CHOSEN if view.name in chosen else ""


def _cell(view: LinkView | None) -> str:
    if view is None:
        return "background:rgba(128,140,160,.07);height:20px"
    known = view.age is not None or view.cut
    colour = colours.css_health(view.level) if known else f"#{DARK.muted}"
    text = "color:#10151a;font-weight:700;text-align:center;white-space:nowrap;overflow:hidden"
    return f"background:{colour};{text};height:20px"


def _cell_text(view: LinkView) -> str:
    if view.age is None:
        return view.label
    number, unit = duration(view.age)
    text = f"{number} {unit}"
    if view.lost:
        text = f"{view.label} {text}"
    if view.loss >= 0.005 and not view.lost:
        text += f'<span style="font-weight:400"> -{100 * view.loss:.0f} %</span>'
    return text
