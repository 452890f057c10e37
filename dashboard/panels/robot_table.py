"""The table of the Robots tab: a row per robot, with buttons that kill and restart its agent."""

from typing import NamedTuple

from dashboard.panels.clickable import Clickable
from dashboard.panels.hops import robot_labels
from dashboard.panels.run_summary import lag
from dashboard.telemetry.links import LinkView
from dashboard.telemetry.snapshot import Snapshot
from dashboard.theme.formatting import duration
from dashboard.theme.limits import LAG_LIMIT
from dashboard.theme.palette import hue
from dashboard.theme.templates import render
from network.messages import State, Status

BUTTONS = {"kill": "bad", "restart": "muted", "leave": "muted"}
"""Buttons of a row and their colours."""
SIGNS = {"kill": "✕", "restart": "↻", "leave": "−", "join": "+"}
"""What stands on them: words would be wider than the panel."""

MOST = 64
"""With more robots those that need a look are shown, and of the others the first."""


class Row(NamedTuple):
    """One robot."""

    robot: int
    hue: str
    agent: str
    """Health of its agent in a word, its lag, whom it keeps off, or that its solver does not converge."""
    level: float
    """0 is healthy, 1 lost."""
    process: str
    link: LinkView | None
    """The link to it; None if it has left the ring."""
    status: Status | None
    """The newest of this episode."""
    error: float
    """Of the distance to the robot upstream [m]."""
    buttons: dict[str, str]
    """Verbs and their colours."""


def robot_table(snapshot: Snapshot, links: list[LinkView], clickable: Clickable) -> str:
    """HTML of the table.

    Args:
        snapshot: what is known.
        links: of the ring, ordered by sender.
        clickable: takes "focus", "kill" and "restart" with a robot.
    """
    state = snapshot.state
    labels = [] if state is None else robot_labels(state)
    to = {link.receiver: link for link in links}
    rows = [
        _row(state, i, label, snapshot.statuses.get(i), to.get(i))
        for i, label in enumerate(labels, 1)
        if state is not None
    ]
    left_out = max(0, len(rows) - MOST)
    if left_out:
        worst = sorted(rows, key=lambda row: -max(row.level, row.link.level if row.link else 0.0))[:MOST]
        rows = sorted(worst, key=lambda row: row.robot)
    told = snapshot.scenario is not None and snapshot.scenario.path.known_to == "leader"
    return render(
        "panels/robot_table.html",
        rows=rows,
        told=told,
        left_out=left_out,
        signs=SIGNS,
        clickable=clickable,
        noise=snapshot.noise,
    )


def _row(state: State, robot: int, label: str, status: Status | None, link: LinkView | None) -> Row:
    status = status if status is not None and status.episode == state.episode else None
    level, behind = 0.0 if label == "OK" else 1.0, lag(status, state)
    agent = "alive" if label == "OK" else label
    if label == "OK" and behind > LAG_LIMIT:
        level, agent = 0.5, f"−{' '.join(duration(behind))}"
    if label == "OK" and status is not None and status.keeps_off:
        level, agent = 0.5, f"off R{status.keeps_off}"
    if label == "OK" and status is not None and not status.converged:
        level, agent = 1.0, "NO SOLUTION"
    return Row(
        robot=robot,
        hue=hue(robot, len(state.poses)),
        agent=agent,
        level=level,
        process=f"process {status.pid}" if status is not None and label not in ("KILLED", "LOST") else "no process",
        link=link,
        status=status,
        error=abs(float(state.distance_errors[robot - 1])),
        buttons=_buttons(state, robot),
    )


def _buttons(state: State, robot: int) -> dict[str, str]:
    """Of an agent that was killed, restart alone, in green; of a robot that has left the ring, join in green."""
    if robot in state.dismissed:
        return {"restart": "ok"}
    if robot in state.away:
        return {**{verb: colour for verb, colour in BUTTONS.items() if verb != "leave"}, "join": "ok"}
    return BUTTONS
