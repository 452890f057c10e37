"""The strip of robots: how each is and, where robot 1 alone knows the way, how old the others' knowledge of it is."""

from typing import NamedTuple

from dashboard.telemetry.links import LOST_SECONDS, LinkView
from dashboard.telemetry.snapshot import Snapshot
from dashboard.theme.formatting import duration
from dashboard.theme.palette import hue
from formation.link_ids import DRIVING
from network.messages import State

FEW = 8
"""Of more robots those that need a look are shown, and the others are counted."""
MOST = 15
"""Robots of a crowd that are shown, at most."""
ON, BROKEN = "→", "✕"
"""Between two robots: the link passes plans on, or does not."""


class Hop(NamedTuple):
    """A robot in the strip."""

    hue: str
    name: str
    text: str
    """What is wrong with it, or how old its knowledge is; empty if there is nothing to say."""
    level: float
    """0 is healthy, 1 the limit."""
    mark: str = ""
    """Between it and the next robot."""


class Strip(NamedTuple):
    """What the strip shows."""

    title: str
    hops: list[Hop]


def hops(snapshot: Snapshot, links: list[LinkView]) -> Strip:
    """The robots of a moment, in the order in which they are told the way."""
    state, scenario = snapshot.state, snapshot.scenario
    if state is None:
        return Strip("", [])
    n = len(state.poses)
    told = scenario is not None and scenario.path.known_to == "leader" and n > 1
    ages = way_ages(snapshot) if told else {}
    found = [_hop(snapshot, n, robot, label, ages.get(robot)) for robot, label in enumerate(robot_labels(state), 1)]
    if n > FEW:
        return Strip(_title(told, _driven(snapshot)), _crowd(found, told=told))
    if told:
        marks = {link.sender: BROKEN if link.cut or link.lost else ON for link in links if link.receiver > link.sender}
        found = [hop._replace(mark=marks.get(robot, "")) for robot, hop in enumerate(found, 1)]
    return Strip(_title(told, _driven(snapshot)), found)


def way_ages(snapshot: Snapshot) -> dict[int, float]:
    """By robot, how old its knowledge of the way is [s], all hops added up; of orders, since the driver gave them."""
    told = {robot: status.way_age for robot, status in sorted(snapshot.statuses.items())}
    first = told.get(DRIVING.receiver, 0.0)
    return {robot: age + (first if robot != DRIVING.receiver else 0.0) for robot, age in told.items()}


def oldest_way(snapshot: Snapshot) -> float | None:
    """The largest of these ages [s]; None if every robot knows the path itself."""
    scenario = snapshot.scenario
    if scenario is None or scenario.path.known_to != "leader" or scenario.size < 2:
        return None
    return max(way_ages(snapshot).values(), default=0.0)


def _driven(snapshot: Snapshot) -> bool:
    return snapshot.scenario is not None and snapshot.scenario.driven


def _title(told: bool, driven: bool) -> str:
    if not told:
        return ""
    return "Age of the orders, hop by hop" if driven else "Knowledge of the way, hop by hop"


def _hop(snapshot: Snapshot, n: int, robot: int, label: str, age: float | None) -> Hop:
    status = snapshot.statuses.get(robot)
    if label != "OK":
        text, level = label, 1.0
    elif age is None:
        text, level = "", 0.0
    elif robot == snapshot.leader and not _driven(snapshot):
        text, level = "knows", 0.0
    else:
        text = " ".join(duration(age))
        level = 1.0 if status is not None and status.lost else min(1.0, age / LOST_SECONDS)
    return Hop(hue(robot, n), f"R{robot}", text, level)


def _crowd(found: list[Hop], *, told: bool) -> list[Hop]:
    """Those that need a look, the worst first, and how many do not."""
    bad = sorted((hop for hop in found if hop.level > 0.5), key=lambda hop: -hop.level)
    well = len(found) - len(bad)
    rest = f"{well} robots" if len(bad) <= MOST else f"{len(found) - MOST} more"
    return [*bad[:MOST], Hop(found[0].hue, rest, "know the way" if told and not bad else "", 0.0 if well else 1.0)]


def robot_labels(state: State) -> list[str]:
    """How each robot is, in a word."""
    live, away, dismissed, stopped = map(set, (state.live, state.away, state.dismissed, state.stopped))

    def label(robot: int) -> str:
        if robot in away and robot in live:
            return "AWAY"
        if robot not in live:
            return "KILLED" if robot in dismissed else "LOST"
        return "HELD" if robot in stopped else "OK"

    return [label(robot) for robot in range(1, len(state.poses) + 1)]
