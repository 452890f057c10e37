"""Faults: how people write them, when the schedule has them on, and which layer wins."""

from typing import Any

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from formation.errors import FaultError
from formation.faults import (
    PERFECT,
    PRESETS,
    SHOWN,
    Fault,
    ScheduledFault,
    preset,
    with_changes,
)
from formation.link_ids import LinkId, every_link, links_named, plan_links
from formation.scenario.files import parse
from formation.scenario.scenario import Scenario
from formation.units import seconds, share
from tests.strategies import of
from world.faults import FaultState
from world.world import World

RAW = {"name": "small", "path": {"kind": "circle"}, "formation": {"shape": "triangle"}}


def scenario(*faults: dict[str, Any], **link: Any) -> Scenario:
    return parse({**RAW, "link": link, "faults": list(faults)})


def state(*faults: dict[str, Any], **link: Any) -> FaultState:
    fresh = FaultState(scenario(*faults, **link))
    fresh.update(0.0)
    return fresh


# ---------------------------------------------------------------- quantities


@pytest.mark.parametrize(
    ("text", "value"),
    [("300ms", 0.3), ("0.3s", 0.3), ("0.3", 0.3), (" 2 min ", 120.0), ("0s", 0.0), ("1e3ms", 1.0), ("5 s", 5.0)],
)
def test_a_time_may_be_written_with_its_unit(text: Any, value: Any) -> None:
    assert seconds(text) == pytest.approx(value)
    assert Fault(latency=text).latency == pytest.approx(value)


@pytest.mark.parametrize(("text", "value"), [("30%", 0.3), ("0.3", 0.3), (" 30 % ", 0.3), ("0%", 0.0), ("100%", 1.0)])
def test_a_share_may_be_written_in_per_cent(text: Any, value: Any) -> None:
    assert share(text) == pytest.approx(value)
    assert Fault(loss=text).loss == pytest.approx(value)


@given(st.floats(0, 1e6))
def test_numbers_pass_as_they_are(number: Any) -> None:
    assert seconds(number) == number
    assert share(number) == number


@pytest.mark.parametrize("text", ["", "ms", "fast", "3h", "3%", "1,5s", "--3s"])
def test_a_time_that_is_none_is_refused_with_an_example(text: Any) -> None:
    with pytest.raises(ValueError, match=r"300ms.*got"):
        seconds(text)


@pytest.mark.parametrize("text", ["", "%", "half", "3 percent", "0.3s"])
def test_a_share_that_is_none_is_refused_with_an_example(text: Any) -> None:
    with pytest.raises(ValueError, match=r"30%.*got"):
        share(text)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"loss": "130%"}, ["loss", "at most 1"]),
        ({"latency": "-1s"}, ["latency", "at least 0"]),
        ({"latency": "inf"}, ["latency", "finite"]),
        ({"latency": "nan"}, ["latency"]),
        ({"latency": "soon"}, ["latency", "300ms", "soon"]),
        ({"lag": 1}, ["lag: unknown key", "latency", "loss"]),
        ({"distribution": "cauchy"}, ["distribution", "uniform, normal, pareto"]),
        ({"cut": "perhaps"}, ["cut", "true or false"]),
        ({"rate": -1, "loss": 2}, ["rate", "loss"]),
    ],
)
def test_a_wrong_change_is_one_line_with_key_and_choices(changes: Any, words: Any) -> None:
    with pytest.raises(FaultError) as caught:
        with_changes(PERFECT, changes)
    assert "\n" not in str(caught.value)
    for word in words:
        assert word in str(caught.value)


# ---------------------------------------------------------------- links and presets


def names(links: list[LinkId]) -> list[str]:
    return [str(link) for link in links]


@given(st.integers(0, 64), st.integers(0, 64))
def test_a_link_is_read_back_from_its_text(sender: int, receiver: int) -> None:
    assume(sender != receiver)
    assert LinkId.parse(str(LinkId(sender, receiver))) == (sender, receiver)


@given(st.text(st.sampled_from("worldx0123456789->→ -"), max_size=12))
def test_any_text_is_a_link_or_refused(text: str) -> None:
    try:
        link = LinkId.parse(text)
    except FaultError:
        return
    assert str(link).split("->") == [end.strip() for end in text.replace("→", "->").split("->")]


def test_the_links_of_a_ring_lead_downstream() -> None:
    assert names(plan_links(2)) == ["1->2", "2->1"]
    assert names(plan_links(3)) == ["1->2", "2->3", "3->1"]
    assert names(every_link(2)) == ["1->2", "2->1", "world->1", "1->world", "world->2", "2->world"]


@pytest.mark.parametrize("text", ["2->3", " 2 -> 3 ", "2→3", "2 → 3"])
def test_a_link_may_be_written_with_spaces_or_an_arrow(text: Any) -> None:
    assert names(links_named(text, 3)) == ["2->3"]


def test_all_means_the_ring() -> None:
    assert names(links_named("all", 3)) == ["1->2", "2->3", "3->1"]
    assert names(links_named("world->2", 3)) == ["world->2"]


@pytest.mark.parametrize("text", ["3->2", "1->4", "1", "", "ALL", "world", "world->4", "1->2->3"])
def test_an_unknown_link_is_refused_with_the_choices(text: Any) -> None:
    with pytest.raises(FaultError, match=r"link: expected one of all, 1->2, 2->3, 3->1, world->1, 1->world"):
        links_named(text, 3)


def test_an_unknown_preset_is_refused_with_the_choices_and_the_nearest() -> None:
    assert preset("wifi") is PRESETS["wifi"]
    with pytest.raises(FaultError, match=r"satellite.*did you mean bursty\?"):
        preset("burst")


def test_an_entry_of_the_schedule_changes_only_the_keys_that_it_names() -> None:
    assert ScheduledFault(at=1, loss=0.5).changes() == {"loss": 0.5}
    assert ScheduledFault(at=1).changes() == {}
    assert ScheduledFault(loss=0.0).changes() == {"loss": 0.0}  # named, though it is the default


def test_a_preset_in_the_schedule_sets_every_key_and_keys_beside_it_refine_it() -> None:
    changes = ScheduledFault(preset="bursty", loss=0.1).changes()
    assert changes == PRESETS["bursty"].model_dump() | {"loss": 0.1}


@pytest.mark.parametrize("name", PRESETS)
def test_a_fault_said_in_words_names_what_is_wrong(name: Any) -> None:
    fault = PRESETS[name]
    words = fault.words()
    assert words != "healthy"
    assert ("latency" in words) == (fault.latency > 0)
    assert PERFECT.words() == "healthy"


@given(of(Fault))
def test_the_keys_that_differ_from_a_perfect_link_say_all(fault: Any) -> None:
    assert with_changes(PERFECT, fault.plain()) == fault
    assert (fault.plain() == {}) == (fault == PERFECT)


# ---------------------------------------------------------------- the schedule


def test_the_schedule_is_on_from_its_first_tick_to_before_its_last() -> None:
    world = World(scenario({"at": 0.05, "until": 0.1, "link": "1->2", "loss": 0.5}))
    on = []
    while world.k < 15:
        if LinkId(1, 2) in world.faults.table:
            on.append(world.k)
        world.advance({})
    assert on == [5, 6, 7, 8, 9]


def test_the_ticks_of_a_schedule_do_not_suffer_from_rounding() -> None:
    # k * 0.01 is not exact: 0.29 is 29 * 0.01 = 0.29000000000000004 or below, by chance.
    for k in range(1, 300):
        faults = state({"at": k / 100, "until": (k + 1) / 100, "cut": True})
        faults.update((k - 1) * 0.01)
        assert faults.table == {}
        faults.update(k * 0.01)
        assert set(faults.table) == set(plan_links(3))
        faults.update((k + 1) * 0.01)
        assert faults.table == {}


def test_a_fault_without_an_end_stays() -> None:
    faults = state({"at": 1.0, "link": "world->2", "latency": "100ms"})
    faults.update(1e6)
    assert faults.table == {LinkId(0, 2): Fault(latency=0.1)}


def test_an_update_tells_every_link_that_changed_once() -> None:
    faults = state({"at": 1.0, "until": 2.0, "link": "2->3", "loss": 0.5})
    assert faults.update(0.99) == []
    assert faults.update(1.0) == [(LinkId(2, 3), Fault(loss=0.5))]
    assert faults.update(1.01) == []
    assert faults.update(2.0) == [(LinkId(2, 3), PERFECT)]
    assert faults.update(2.01) == []


@given(
    st.lists(
        st.tuples(st.integers(0, 60), st.integers(1, 30), st.sampled_from(["1->2", "all", "world->3"])), max_size=4
    ),
    st.tuples(st.integers(0, 40), st.integers(1, 20)),
)
def test_a_table_that_is_updated_when_it_is_due_is_right_at_every_tick(
    entries: list[tuple[int, int, str]], wish: tuple[int, int]
) -> None:
    keys = [
        {"at": at / 100, "until": (at + lasts) / 100, "link": link, "loss": (index + 1) / 10}
        for index, (at, lasts, link) in enumerate(entries)
    ]
    patient, at_every_tick = state(*keys, latency=0.1), state(*keys, latency=0.1)
    for k in range(100):
        now = k * 0.01
        for faults in (patient, at_every_tick):
            if k == wish[0]:
                faults.change("2->3", {"cut": True}, (k + wish[1]) / 100, now)
        at_every_tick.due = 0.0
        at_every_tick.update(now)
        if now >= patient.due:
            patient.update(now)
        assert patient.table == at_every_tick.table


# ---------------------------------------------------------------- layers


def test_later_layers_win_key_by_key() -> None:
    faults = state({"at": 1.0, "link": "1->2", "loss": 0.5}, {"at": 2.0, "link": "1->2", "jitter": 0.1}, latency=0.2)
    assert faults.table == dict.fromkeys(plan_links(3), Fault(latency=0.2))
    faults.update(1.0)
    assert faults.table[LinkId(1, 2)] == Fault(latency=0.2, loss=0.5)
    assert faults.table[LinkId(2, 3)] == Fault(latency=0.2)
    faults.update(2.0)
    assert faults.table[LinkId(1, 2)] == Fault(latency=0.2, loss=0.5, jitter=0.1)
    faults.change("1->2", {"loss": 0.1}, None, 0.0)
    faults.update(2.0)
    assert faults.table[LinkId(1, 2)] == Fault(latency=0.2, loss=0.1, jitter=0.1)


def test_the_scenarios_link_holds_for_the_ring_and_not_for_poses_and_commands() -> None:
    assert set(state(latency=0.2).table) == set(plan_links(3))


def test_what_a_person_sets_ends_at_its_time() -> None:
    faults = state(latency=0.2)
    faults.change("all", {"cut": True}, 5.0, 0.0)
    faults.update(4.99)
    assert all(fault.cut for fault in faults.table.values())
    faults.update(5.0)
    assert faults.table == dict.fromkeys(plan_links(3), Fault(latency=0.2))


def test_a_second_change_adds_to_the_first() -> None:
    faults = state()
    faults.change("1->2", {"latency": "300ms"}, None, 0.0)
    faults.change("1->2", {"loss": "30%"}, None, 0.0)
    faults.update(0.0)
    assert faults.table == {LinkId(1, 2): Fault(latency=0.3, loss=0.3)}


def test_a_change_back_to_healthy_takes_the_link_from_the_table() -> None:
    faults = state(latency=0.2)
    faults.change("1->2", {"latency": 0}, None, 0.0)
    faults.update(0.0)
    assert set(faults.table) == {LinkId(2, 3), LinkId(3, 1)}


@pytest.mark.parametrize(("link", "changes"), [("1->3", {"loss": 0.5}), ("1->2", {"los": 0.5}), ("all", {"loss": 7})])
def test_a_wrong_change_changes_nothing(link: Any, changes: Any) -> None:
    faults = state(latency=0.2)
    before = dict(faults.table)
    with pytest.raises(FaultError):
        faults.change(link, changes, None, 0.0)
    assert faults.update(0.0) == []
    assert faults.table == before


@pytest.mark.parametrize(
    ("until", "line"),
    [
        ("2x", "until: expected a time such as 300ms"),
        (float("nan"), "until: expected a finite number"),
        (float("inf"), "until: expected a finite number"),
        ([3.0], "until: expected a number"),
        (0.5, "until: expected a simulated time later than now, 1 s; got 0.5"),
        ("1s", "later than now"),
        (1.0 + 1e-10, "later than now"),
        (1e12, "until: expected at most 1e"),
    ],
)
def test_an_end_that_is_none_or_over_is_refused_and_changes_nothing(until: Any, line: str) -> None:
    faults = state(latency=0.2)
    before = dict(faults.table)
    with pytest.raises(FaultError, match=line):
        faults.change("1->2", {"cut": True}, until, 1.0)
    assert faults.update(1.0) == []
    assert faults.table == before


def test_an_end_may_be_written_with_its_unit() -> None:
    faults = state()
    faults.change("1->2", {"cut": True}, "2000ms", 1.0)
    faults.update(1.99)
    assert faults.table == {LinkId(1, 2): Fault(cut=True)}
    faults.update(2.0)
    assert not faults.table


def test_clearing_takes_back_what_people_set_and_ends_what_the_schedule_has_on() -> None:
    later = {"at": 9.0, "link": "1->2", "jitter": 0.1}
    faults = state({"at": 1.0, "link": "1->2", "loss": 0.5}, later, latency=0.2)
    faults.update(1.0)
    faults.change("1->2", {"cut": True}, None, 0.0)
    faults.change("2->3", {"cut": True}, None, 0.0)
    faults.update(1.0)
    faults.clear("1->2", 2.0)
    faults.update(2.0)
    assert faults.table[LinkId(1, 2)] == Fault(latency=0.2)  # [link] stays
    assert faults.table[LinkId(2, 3)].cut  # another link
    faults.update(9.0)
    assert faults.table[LinkId(1, 2)] == Fault(latency=0.2, jitter=0.1)  # what comes later comes
    faults.clear("all", 9.0)
    faults.update(9.0)
    assert faults.table == dict.fromkeys(plan_links(3), Fault(latency=0.2))


def test_clearing_all_takes_back_what_people_set_on_poses_and_commands_too() -> None:
    faults = state()
    faults.change("world->1", {"cut": True}, None, 0.0)
    faults.change("2->world", {"cut": True}, None, 0.0)
    faults.update(0.0)
    assert len(faults.table) == 2
    faults.clear("all", 0.0)
    faults.update(0.0)
    assert faults.table == {}


def test_clearing_an_unknown_link_is_an_error() -> None:
    with pytest.raises(FaultError, match="3->1"):
        state().clear("1->3", 0.0)


def test_a_restart_makes_the_schedule_whole_and_keeps_what_people_set_without_an_end() -> None:
    faults = state({"at": 1.0, "until": 3.0, "link": "1->2", "loss": 0.5})
    faults.update(1.0)
    faults.change("2->3", {"latency": 0.1}, None, 0.0)
    faults.change("3->1", {"cut": True}, 100.0, 0.0)
    faults.clear("1->2", 1.5)
    faults.update(1.5)
    assert set(faults.table) == {LinkId(2, 3), LinkId(3, 1)}
    faults.restart()
    faults.update(0.0)
    assert faults.table == {LinkId(2, 3): Fault(latency=0.1)}
    faults.update(1.0)
    assert faults.table == {LinkId(1, 2): Fault(loss=0.5), LinkId(2, 3): Fault(latency=0.1)}


def test_every_key_of_a_fault_has_its_words_and_a_slider_covers_the_presets() -> None:
    assert set(SHOWN) == set(Fault.model_fields)
    assert all(field.description for field in Fault.model_fields.values())
    for fault in PRESETS.values():
        for key, value in fault.plain().items():
            if SHOWN[key].top:
                assert SHOWN[key].shown(value) <= SHOWN[key].top
