"""Numbers of robots as users write them: "1-3,5"."""

from collections.abc import Iterable

from formation.errors import EchelonError
from formation.schema import MAX_ROBOTS


def parsed(text: str) -> frozenset[int]:
    """The robots that are meant.

    Raises:
        EchelonError: it is no list of numbers, or they are too large.
    """
    found: set[int] = set()
    for part in text.replace(" ", "").split(","):
        first, dash, last = part.partition("-")
        ends = (first, last if dash else first)
        if not all(end.isascii() and end.isdigit() and 1 <= int(end[:6]) <= MAX_ROBOTS for end in ends):
            raise EchelonError(f"expected robots from 1 to {MAX_ROBOTS}, such as 1-4 or 1,3; got {text!r:.40}")
        if int(ends[0]) > int(ends[1]):
            raise EchelonError(f"expected the lower number first, such as 1-4; got {part}")
        found |= set(range(int(ends[0]), int(ends[1]) + 1))
    return frozenset(found)


def spelled(robots: Iterable[int]) -> str:
    """The same as text; "none" without any."""
    parts: list[list[int]] = []
    for robot in sorted(robots):
        if parts and robot == parts[-1][1] + 1:
            parts[-1][1] = robot
        else:
            parts.append([robot, robot])
    return ",".join(f"{first}-{last}" if first < last else str(first) for first, last in parts) or "none"
