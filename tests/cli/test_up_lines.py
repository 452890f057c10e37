"""Laws of what `up` tells of a run."""

from cli.live.up import lines
from network.values import Event


def event(number: int, stamp: float, text: str) -> Event:
    return Event(number, stamp, "agent", text)


def test_agents_that_come_one_after_the_other_are_one_line_and_all_else_is_told_as_it_is() -> None:
    come = [event(i, 0.0, f"agent {robot} is here") for i, robot in enumerate((2, 1, 3, 7), 1)]
    later = [event(5, 4.0, "agent 2 lost"), event(6, 5.25, "agent 2 is here"), event(7, 5.25, "whole again")]
    assert list(lines([*come, *later])) == [
        "t = 0.00 s: agents 1-3,7 are here",
        "t = 4.00 s: agent 2 lost",
        "t = 5.25 s: agent 2 is here",
        "t = 5.25 s: whole again",
    ]
    assert list(lines(come[:1])) == ["t = 0.00 s: agent 2 is here"]
    assert list(lines([])) == []
