"""Laws of contacts: a pair that comes to touch is one contact, an event and a figure of the summary."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from formation.scenario.files import load
from tests.builders import command
from world.measures import contacts as contacts_module
from world.measures.contacts import RELEASE, AtLimits, Contacts
from world.world import World


def in_line(*places: float) -> np.ndarray:
    return np.array([[x, 0.0, 0.0] for x in places])


def test_two_touch_when_their_centres_are_closer_than_their_radii() -> None:
    contacts = Contacts([0.1, 0.2, 0.1])
    assert contacts.look(in_line(0.0, 0.31, 1.0)) == []
    assert contacts.look(in_line(0.0, 0.29, 1.0)) == [(1, 2)]
    assert contacts.count == 1
    assert contacts.gap == pytest.approx(-0.01)
    assert contacts.clearance == pytest.approx(0.29)


def test_a_pair_that_stays_in_touch_is_one_contact_until_it_has_parted() -> None:
    contacts = Contacts([0.1, 0.1])
    for gap in (-0.001, RELEASE / 2.0, -0.001, RELEASE / 2.0):
        contacts.look(in_line(0.0, 0.2 + gap))
    assert contacts.count == 1
    contacts.look(in_line(0.0, 0.2 + 2.0 * RELEASE))
    assert contacts.look(in_line(0.0, 0.2 - 0.001)) == [(1, 2)]
    assert contacts.count == 2


@given(st.lists(st.tuples(*[st.floats(-1, 1)] * 4), min_size=1, max_size=20), st.floats(0.01, 0.5))
def test_there_is_a_contact_exactly_if_the_least_gap_is_negative(
    places: list[tuple[float, ...]], radius: float
) -> None:
    contacts = Contacts([radius] * 4)
    for where in places:
        contacts.look(in_line(*where))
    assert (contacts.count > 0) == (contacts.gap < 0.0)


@pytest.mark.parametrize("radii", [[0.05] * 30, [0.02, 0.03, 0.08] * 10])
def test_of_a_crowd_those_that_are_near_say_the_same_as_all_pairs(
    radii: list[float], monkeypatch: pytest.MonkeyPatch
) -> None:
    draws = np.random.default_rng(3)
    every = Contacts(radii)
    monkeypatch.setattr(contacts_module, "CROWD", 4)
    near = Contacts(radii)
    poses = draws.uniform(0.0, 1.5, (30, 3))
    for _ in range(200):
        poses = poses + draws.normal(0.0, 0.01, (30, 3))
        assert near.look(poses) == every.look(poses)
        assert (near.count, near.clearance, near.gap) == (every.count, every.clearance, every.gap)
    assert every.count > 10


def test_a_world_counts_contacts_also_when_it_keeps_no_trace() -> None:
    wide = {"bodies": {"robots": [{"robot": 2, "radius": 0.3}]}}
    for endless in (False, True):
        world = World(load("triangle-circle", wide), endless=endless)
        assert world.contacts.count == 2
        assert world.state(seq=1, status="running").gap < 0.0
        texts = [event.text for event in world.events if event.kind == "contact"]
        assert texts == ["robots 1 and 2 touch", "robots 2 and 3 touch"]
    assert World(load("triangle-circle")).contacts.count == 0


def test_a_reset_forgets_contacts() -> None:
    world = World(load("triangle-circle"))
    world.contacts.look(np.zeros((3, 3)))
    assert world.contacts.count == 3
    world.reset()
    assert world.contacts.count == 0


def test_a_summary_has_contacts_and_the_time_at_a_limit_and_outside_the_arena() -> None:
    world = World(load("triangle-circle", {"bodies": {"arena": [-9.0, -9.0, -8.0, -8.0]}}))
    limit = world.scenario.robots.limits.v
    for k in range(10):
        world.advance({1: command(1, k, v=-limit), 2: command(2, k, v=limit / 2.0)})
    summary = world.summary()
    assert summary["contacts"] == world.contacts.count
    assert summary["clearance_m"] == world.contacts.clearance
    at_limit = [summary["robots"][robot]["limit_s"] for robot in ("1", "2", "3")]
    assert at_limit == pytest.approx([10 * world.scenario.control_interval, 0.0, 0.0])
    assert summary["robots"]["3"]["left_arena_s"] == pytest.approx(world.now)


def test_without_an_arena_nobody_leaves_it() -> None:
    assert AtLimits(load("triangle-circle")).summary(1)["left_arena_s"] is None
