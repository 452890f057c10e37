"""Laws of an episode that is stepped from outside: what is refused changes nothing, and says why in one line."""

import copy
import pickle
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import echelon
from tests.user_code import Write, clean, hold_slot

__all__ = ["clean", "hold_slot"]
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


COPIES: list[Any] = [copy.deepcopy, copy.copy, lambda one: pickle.loads(pickle.dumps(one))]


@pytest.mark.parametrize("copied", COPIES)
@pytest.mark.parametrize(
    ("name", "overrides"),
    [
        ("triangle-circle", {"noise": {"slip": 0.1}, "link": {"loss": 0.2, "latency": 0.05, "burst": 3}}),
        ("triangle-circle", {"bodies": "camera"}),
        ("triangle-circle", {"controller": {"name": "centralised"}}),
        ("drive-me", {"path": {"commands": [[0.0, 0.1, 0.2], [1.0, 0.1, -0.2]]}}),
        ("ring-16", {"formation": {"robots": 5}, "membership": {"changes": [{"robot": 3, "leave": 0.5}]}}),
    ],
)
def test_a_copy_goes_on_to_the_same_bits_and_apart(copied: Any, name: str, overrides: Any) -> None:
    simulation = echelon.Simulation(echelon.load(name, {"duration": 1.5, **overrides}))
    simulation.step(70)
    simulation.set_fault("1->2", cut=True, until=1.0)
    simulation.push(1, "gust", seconds=0.3)
    other = copied(simulation)
    other.step(40)
    assert (simulation.time, other.time) == pytest.approx((0.7, 1.1))
    for one in (simulation, other):
        while not one.finished:
            one.step(7)
    here, there = simulation.result(), other.result()
    measured = {"wall_s", "solve_s"}
    assert {k: v for k, v in here.summary().items() if k not in measured} == {
        k: v for k, v in there.summary().items() if k not in measured
    }
    np.testing.assert_array_equal(here.distance_errors, there.distance_errors)
    np.testing.assert_array_equal(here.ages, there.ages)
    assert 0.0 < there.summary()["wall_s"] < 600.0


def test_a_copy_of_a_users_own_controller_goes_on_to_the_same_bits(hold_slot: Write) -> None:
    own = hold_slot("self.calls = getattr(self, 'calls', 0) + 1; observation.limits[0] * self.calls")
    simulation = echelon.Simulation(echelon.load("triangle-circle", {"duration": 1, "robots": {}}, controller=own))
    simulation.step(30)
    others = [copied(simulation) for copied in COPIES]
    for one in (simulation, *others):
        one.step(70)
    assert {one.result().trajectory_sha256 for one in others} == {simulation.result().trajectory_sha256}


@pytest.mark.parametrize(("copied", "how"), [(copy.deepcopy, "copied"), (pickle.dumps, "pickled")])
def test_a_part_of_a_users_own_that_cannot_be_copied_is_one_line(copied: Any, how: str, hold_slot: Write) -> None:
    locked = hold_slot("import threading; self.lock = threading.Lock()")
    simulation = echelon.Simulation(echelon.load("triangle-circle", {"duration": 1, "robots": {}}, controller=locked))
    simulation.step(2)
    with pytest.raises(echelon.EchelonError, match=f"expected parts that can be {how}.*TypeError: cannot pickle"):
        copied(simulation)
    simulation.step(2)
    assert simulation.time == pytest.approx(0.04)
