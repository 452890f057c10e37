"""Chips at robots: who knows the path, how old the others' knowledge of it is, and beliefs that are far off."""

from collections.abc import Collection
from typing import NamedTuple

from dashboard.telemetry.beliefs import BeliefView
from dashboard.telemetry.links import LOST_SECONDS
from dashboard.telemetry.snapshot import Snapshot
from dashboard.theme.formatting import duration, length
from dashboard.theme.limits import DISTANCE_LIMIT
from dashboard.theme.palette import hue

MOST = 10
"""Chips at once; the first are the most important."""

COUNTED = 6
"""Of a formation that is driven, at most so many robots have a chip with their hops while all is well."""


class Chip(NamedTuple):
    """A few words at a place in the scene."""

    key: str
    """Stays while the chip is about the same thing."""
    node: str
    """Of the scene; the chip is at one of its instances."""
    instance: int
    """Its number, from 0."""
    hues: tuple[str, ...]
    """CSS colours of its dots."""
    number: str
    """Stressed."""
    text: str
    colour: str
    """Name of the colour of what is stressed; empty for the text's own."""


def chips(snapshot: Snapshot, beliefs: list[BeliefView]) -> list[Chip]:
    """What stands at the robots now, the most important first."""
    state, scenario = snapshot.state, snapshot.scenario
    if state is None or scenario is None:
        return []
    n = len(state.poses)
    gone = sorted(set(range(1, n + 1)) - set(state.live))[:MOST]
    found = [Chip(f"gone {i}", "/bodies", i - 1, (hue(i, n),), "no agent", "", "bad") for i in gone]
    for belief in sorted(beliefs, key=lambda belief: -belief.error):
        if belief.error > DISTANCE_LIMIT:
            text = f"{belief.receiver} believes {belief.sender} here:"
            number = " ".join(length(belief.error)) + " off"
            hues = (hue(belief.receiver, n), hue(belief.sender, n))
            found.append(Chip(f"off {belief.receiver}", "/believed", belief.sender - 1, hues, number, text, "bad"))
    if scenario.path.known_to == "leader" and n > 1:
        found += _ways(snapshot, state.away, n, driven=scenario.driven)
    return found[:MOST]


def _ways(snapshot: Snapshot, away: Collection[int], n: int, *, driven: bool) -> list[Chip]:
    """Who knows the path, and whose knowledge is old; robots that are away have none."""
    first = snapshot.leader
    statuses = {robot: status for robot, status in snapshot.statuses.items() if robot not in away}
    found = [Chip("knows", "/bodies", first - 1, (hue(first, n),), "driven" if driven else "knows the path", "", "")]
    for robot, status in sorted(statuses.items()):
        hops = sum(i not in away for i in range(first, robot))
        if driven and first < robot <= n <= COUNTED and status.way_age <= LOST_SECONDS:
            age, text = " ".join(duration(status.way_age)), f"{hops} hop{'s' if hops > 1 else ''}"
            found.append(Chip(f"way {robot}", "/bodies", robot - 1, (hue(robot, n),), age, text, "ok"))
        if robot != first and status.way_age > LOST_SECONDS:
            age = " ".join(duration(status.way_age))
            colour = "bad" if status.lost else "warn"
            found.append(
                Chip(f"way {robot}", "/bodies", robot - 1, (hue(robot, n),), age, "since told the way", colour)
            )
        if robot == 2 and status.lost:
            found.append(Chip("told", "/told", 1, (), "", "what 2 was told ended here", "muted"))
    return found
