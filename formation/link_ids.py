"""Directed links by their two ends, and which links a formation has. Text such as "1->2" is parsed here only."""

import re
from collections.abc import Collection
from typing import NamedTuple, Self

from formation.errors import FaultError, unknown
from formation.pattern import downstream, upstream

WORLD, DRIVER = 0, -1
"""Numbers of the world and of who drives the formation, as ends of a link; robots count from 1."""
_SENDER, _RECEIVER = r"(world|driver|[1-9][0-9]{0,3})", r"(world|[1-9][0-9]{0,3})"
_LINK = re.compile(rf"{_SENDER}->{_RECEIVER}")
_NAMES = {WORLD: "world", DRIVER: "driver"}
_NUMBERS = {name: number for number, name in _NAMES.items()}


class LinkId(NamedTuple):
    """A directed link. Its text is "1->2", "world->1" (poses), "1->world" (commands) or "driver->1" (orders)."""

    sender: int
    receiver: int

    def __str__(self) -> str:
        return f"{_text(self.sender)}->{_text(self.receiver)}"

    @classmethod
    def parse(cls, text: str) -> Self:
        """The link of this text; spaces and an arrow sign are forgiven.

        Raises:
            FaultError: the text does not name a link.
        """
        found = _LINK.fullmatch(re.sub(r"\s*(->|→)\s*", "->", text.strip()))
        if found is None or found[1] == found[2]:
            raise FaultError(f"expected a link such as 1->2, world->1, 1->world or driver->1; got {text!r:.40}")
        return cls(_number(found[1]), _number(found[2]))

    @classmethod
    def plans_to(cls, robot: int, robots: int, away: Collection[int] = ()) -> Self:
        """The link over which a robot receives plans, in a ring of so many, of whom some are away."""
        return cls(upstream(robot, robots, away), robot)

    @classmethod
    def plans_from(cls, robot: int, robots: int, away: Collection[int] = ()) -> Self:
        """The link over which a robot sends plans, in a ring of so many, of whom some are away."""
        return cls(robot, downstream(robot, robots, away))

    @classmethod
    def poses_to(cls, robot: int) -> Self:
        """The link over which a robot receives its measured pose."""
        return cls(WORLD, robot)

    @classmethod
    def commands_from(cls, robot: int) -> Self:
        """The link over which a robot sends its commands."""
        return cls(robot, WORLD)


DRIVING = LinkId(DRIVER, 1)
"""The link over which robot 1 hears orders, where the path is driven."""


def _text(end: int) -> str:
    return _NAMES.get(end, str(end))


def _number(end: str) -> int:
    return _NUMBERS[end] if end in _NUMBERS else int(end)


def plan_links(robots: int, *, both: bool = False, away: Collection[int] = ()) -> list[LinkId]:
    """The ring's directed links, in the order of their senders: 1->2, 2->3, ...

    Args:
        robots: how many there are.
        both: whether robots also hear their downstream neighbour: then also 2->1, 3->2, ...
        away: robots that are not in the ring.
    """
    members = [robot for robot in range(1, robots + 1) if robot not in away]
    ring = [LinkId(robot, downstream(robot, robots, away)) for robot in members]
    back = [LinkId(link.receiver, link.sender) for link in ring] if both and len(members) > 2 else []
    return ring + back


def every_link(robots: int, *, both: bool = False, driven: bool = False, away: Collection[int] = ()) -> list[LinkId]:
    """All links that can be given a fault: the ring, each robot's poses and commands, and the orders of a driver.

    The ring is the whole one, and the one that is closed over robots that are away.
    """
    own = [link for robot in range(1, robots + 1) for link in (LinkId.poses_to(robot), LinkId.commands_from(robot))]
    rings = [*plan_links(robots, both=both), *(plan_links(robots, both=both, away=away) if away else [])]
    return [*dict.fromkeys(rings), *own, *([DRIVING] if driven else [])]


def links_named(
    name: str, robots: int, *, both: bool = False, driven: bool = False, away: Collection[int] = ()
) -> list[LinkId]:
    """The links that `name` stands for: itself, or for "all" those of the ring without the robots that are away.

    Raises:
        FaultError: there is no such link; the text lists them.
    """
    if name.strip() == "all":
        return plan_links(robots, both=both, away=away)
    links = every_link(robots, both=both, driven=driven, away=away)
    try:
        link = LinkId.parse(name)
    except FaultError:
        link = None
    if link not in links:
        raise FaultError(unknown("link", str(link or name), ["all", *map(str, links)]))
    return [link]
