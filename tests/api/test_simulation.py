"""Laws of an episode that is stepped from outside: what is refused changes nothing, and says why in one line."""

from collections.abc import Callable
from typing import Any

import pytest

import echelon

Do = Callable[[echelon.Simulation], Any]


def begun(ticks: int = 50) -> echelon.Simulation:
    simulation = echelon.Simulation(echelon.load("triangle-circle", {"duration": 2}))
    simulation.step(ticks)
    return simulation


@pytest.mark.parametrize(
    ("do", "line"),
    [
        (lambda s: s.set_fault("1->2", until="2x", cut=True), "until: expected a time such as 300ms"),
        (lambda s: s.set_fault("1->2", until=float("nan"), cut=True), "until: expected a finite number"),
        (lambda s: s.set_fault("1->2", until=0.3, cut=True), "until: expected a simulated time later than now"),
        (lambda s: s.push(1, "stuck", seconds="x"), "seconds: expected a time such as 300ms"),
        (lambda s: s.push(1, "stuck", seconds=1e-20), "seconds: expected some time, for it to act at all"),
        (lambda s: s.push(1, "stuck", seconds=float("inf")), "seconds: expected a finite number"),
        (lambda s: s.reshape("line", over=-1.0), "over: expected at least 0"),
    ],
)
def test_an_order_with_a_wrong_time_changes_nothing(do: Do, line: str) -> None:
    simulation, plain = begun(), begun()
    with pytest.raises(echelon.EchelonError, match=line):
        do(simulation)
    for one in (simulation, plain):
        one.step(150)
    assert simulation.finished
    assert simulation.result().trajectory_sha256 == plain.result().trajectory_sha256


def test_a_fault_ends_at_a_time_that_may_be_text() -> None:
    one, other = begun(), begun()
    one.set_fault("1->2", until="900ms", latency="300ms")
    other.set_fault("1->2", until=0.9, latency=0.3)
    for simulation in (one, other):
        simulation.step(150)
    ended = [event["t"] for event in one.result().events if event["kind"] == "fault"]
    assert ended == pytest.approx([0.5, 0.9])
    assert one.result().trajectory_sha256 == other.result().trajectory_sha256
