"""The link matrix: the age of the newest plan over every link, and which links are the target of faults."""

from collections.abc import Collection

from dashboard.panels.clickable import Clickable
from dashboard.telemetry.links import LinkView, driver_link
from dashboard.telemetry.snapshot import Snapshot
from dashboard.theme import colours
from dashboard.theme.palette import hue
from dashboard.theme.templates import render
from formation.link_ids import LinkId

MATRIX_ROBOTS = 8
"""With more robots the links are shown as a list."""
MOST = 96
"""With more links the worst are listed."""


def link_matrix(snapshot: Snapshot, links: list[LinkView], clickable: Clickable, target: Collection[str]) -> str:
    """HTML of the links' ages: sender by row, receiver by column; a list if there are many.

    A click on a cell makes that link the target of faults, on a robot its both links, on the corner all.

    Args:
        snapshot: what is known.
        links: of the ring.
        clickable: takes "link" with a sender, "both" with a robot, "all" with 0, "driver" with 1.
        target: names of the links that are the target now; "all" for all of the ring's.
    """
    if snapshot.state is None:
        return ""
    n = len(snapshot.state.poses)
    numbers, left_out = range(1, n + 1), max(0, len(links) - MOST)
    if left_out:
        worst = sorted(links, key=lambda link: (str(link.id) not in target, -link.level, -(link.age or 0.0)))
        links = sorted(worst[:MOST], key=lambda link: link.sender)
    away = snapshot.state.away
    both = {i: {str(LinkId.plans_to(i, n, away)), str(LinkId.plans_from(i, n, away))} for i in numbers}
    driven = snapshot.scenario is not None and snapshot.scenario.driven
    return render(
        "panels/link_matrix.html",
        driver=driver_link(snapshot.state, snapshot.statuses) if driven else None,
        numbers=numbers,
        few=n <= MATRIX_ROBOTS,
        left_out=left_out,
        links={link.id: link for link in links},
        hues={i: hue(i, n) for i in numbers},
        colour_of=_colour,
        target=target,
        targeted_robots={i for i in numbers if n > 2 and both[i] == set(target)},
        clickable=clickable,
    )


def _colour(link: LinkView) -> str:
    """CSS colour of a cell."""
    return colours.css_health(link.level) if link.age is not None or link.cut else "var(--dark-muted)"
