"""The status line above the scene: in a sentence or two, how the formation is, and what of it is wrong first."""

from collections.abc import Iterable
from typing import NamedTuple

from dashboard.telemetry.links import LinkView, oldest
from dashboard.telemetry.snapshot import Snapshot
from dashboard.theme.formatting import duration

LONG = 4
"""More than so many robots are counted, not listed."""


class StatusLine(NamedTuple):
    """What the line reads."""

    colour: str
    """Name of the colour of the headline: ok, warn, bad, or r1 while all is well."""
    headline: str
    """Stressed if something is wrong."""
    rest: str
    """More of it, which narrow pages leave out."""


def status_line(snapshot: Snapshot, links: list[LinkView]) -> StatusLine:
    """How the formation is; of several troubles, the worst."""
    state = snapshot.state
    if state is None or snapshot.scenario is None:
        return StatusLine("muted", "Waiting for the run.", "")
    n = len(state.poses)
    told = snapshot.scenario.path.known_to == "leader" and n > 1
    lost = [robot for robot, status in sorted(snapshot.statuses.items()) if status.lost]
    gone = sorted(set(range(1, n + 1)) - set(state.live))
    worst = max(links, key=lambda link: (link.cut, link.lost and not link.deaf, link.level if not link.deaf else 0.0))
    if worst.cut or (worst.lost and not worst.deaf):
        what = "cut" if worst.cut else "silent"
        since = f" {_time(worst.age)} ago" if worst.age is not None and worst.cut else _for(worst)
        return StatusLine("bad", f"Link {worst.sender} → {worst.receiver} {what}{since}.", _cut(worst, lost, told=told))
    if gone:
        rest = "The others go on with the last plans that they received."
        return StatusLine("bad", f"{_robots(gone)} {'has' if len(gone) == 1 else 'have'} no agent.", rest)
    if state.away:
        verb = "has" if len(state.away) == 1 else "have"
        return StatusLine("warn", f"{_robots(state.away)} {verb} left the ring.", "The others have closed it.")
    if lost:
        rest = "They go on as they last went."
        return StatusLine("bad", f"{_robots(lost)} used up the way that {_was(lost)} told.", rest)
    if worst.level > 0.5 or worst.loss >= 0.05:
        parts = [_time(worst.age or 0.0)] + ([f"{100 * worst.loss:.0f} % lost"] if worst.loss >= 0.005 else [])
        label = "late" if worst.level > 0.5 else "lossy"
        rest = "Each plan is carried forward by its age."
        return StatusLine("warn", f"Link {worst.sender} → {worst.receiver} is {label}: {', '.join(parts)}.", rest)
    fresh = f"All links fresh: oldest plan {_time(oldest(links))}."
    if told:
        first = snapshot.leader
        members = [robot for robot in range(1, n + 1) if robot not in (first, *state.away)]
        ages = [snapshot.statuses[robot].way_age for robot in members if robot in snapshot.statuses]
        others = _robots(members).removeprefix("Robots ").removeprefix("Robot ")
        knows = "hears its driver" if snapshot.scenario.driven else "knows the path"
        learn = f"Robot {first} {knows}; {others} learn it hop by hop within {_time(max(ages, default=0.0))}."
        return StatusLine("r1", learn, "All links fresh.")
    return StatusLine("r1", "Every robot knows the path.", fresh)


def _cut(link: LinkView, lost: list[int], *, told: bool) -> str:
    """What a link that is cut means."""
    if lost:
        return (
            f"{_robots(lost)} used up the way that {_was(lost)} told and {'goes' if len(lost) == 1 else 'go'} on alone."
        )
    if told and link.sender != link.receiver - 1:
        return f"Robot {link.receiver} knows the path itself and goes on."
    if told:
        return f"Robot {link.receiver} and those behind it use the way that they were told."
    return f"Robot {link.receiver} uses the last plan that it received."


def _robots(numbers: Iterable[int]) -> str:
    listed = list(numbers)
    if len(listed) == 1:
        return f"Robot {listed[0]}"
    if len(listed) > LONG:
        return f"{len(listed)} robots"
    return f"Robots {', '.join(map(str, listed[:-1]))} and {listed[-1]}"


def _was(robots: list[int]) -> str:
    return "it was" if len(robots) == 1 else "they were"


def _for(link: LinkView) -> str:
    return f" for {_time(link.age)}" if link.age is not None else ""


def _time(seconds: float | None) -> str:
    return " ".join(duration(seconds or 0.0))
