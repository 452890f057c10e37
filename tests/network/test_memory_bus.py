"""Laws of the memory bus: it carries as the fates say, in the order of time, and who is gone is gone for everybody."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from network import topics
from network.bus import (
    Ask,
    Attendance,
    Connection,
    Incoming,
    Presence,
    Publish,
    Query,
    Response,
    Sample,
    Subscribe,
    perform,
)
from network.codec import decode, encode
from network.control import Pause, request
from network.memory_bus import Letter, MemoryBus, MemoryHub
from network.messages import State
from network.requests import Reply, Request
from network.throttled_log import ThrottledLog
from tests.builders import state

delays = st.lists(st.sampled_from([0.0, 0.1, 0.5, 2.0]), max_size=2).map(tuple)


def joined(hub: MemoryHub) -> tuple[MemoryBus, MemoryBus]:
    """One that publishes states, and one that subscribes to them."""
    one, other = hub.join("x", "one"), hub.join("x", "other")
    one.announce(topics.state("x"))
    other.subscribe(topics.state("x"))
    return one, other


def seqs(items: list[Incoming]) -> list[float]:
    return [decode(State, item.payload).stamp for item in items if isinstance(item, Sample)]


@given(st.lists(delays, max_size=20))
def test_a_letter_arrives_as_often_and_as_late_as_its_fate_says(fates: list[tuple[float, ...]]) -> None:
    hub = MemoryHub(lambda letter: fates[letter.number])
    one, other = joined(hub)
    for number in range(len(fates)):
        one.publish(topics.state("x"), state(stamp=float(number)))
    for moment in (0.0, 0.1, 0.5, 2.0):
        hub.advance(moment)
        due = [float(number) for number, fate in enumerate(fates) for delay in fate if delay == moment]
        assert seqs(other.arrivals()) == due


def test_only_what_was_subscribed_to_arrives_and_of_what_is_kept_the_newest() -> None:
    hub = MemoryHub()
    one, other = joined(hub)
    kept = other.keep(topics.state("x"), 2)
    stranger = hub.join("y")
    stranger.subscribe(topics.state("x"))
    for number in range(3):
        one.publish(topics.state("x"), state(stamp=float(number)))
    other.unsubscribe(topics.state("x"))
    one.publish(topics.state("x"), state(stamp=3.0))
    assert seqs(other.arrivals()) == [0.0, 1.0, 2.0]
    assert seqs(list(kept.take())) == [2.0, 3.0]
    assert not list(kept.take())
    assert not one.arrivals()


def test_what_was_not_announced_cannot_be_published() -> None:
    with pytest.raises(KeyError):
        MemoryHub().join("x").publish(topics.state("x"), state())


def test_a_request_is_answered_over_the_same_uncertain_way() -> None:
    lost = set[int]()

    def fate(letter: Letter) -> tuple[float, ...]:
        return () if letter.number in lost else (1.0,)

    hub = MemoryHub(fate)
    world, user = hub.join("x", "world"), hub.join("x", "user")
    world.serve(topics.control("x"))
    world.serve(topics.question("x"))
    for gone, answered in ((set[int](), True), ({2}, False), ({4}, False)):
        lost |= gone
        perform(user, [Ask(request(Pause()))], ThrottledLog())
        hub.advance(hub.now + 1.0)
        for item in world.arrivals():
            assert isinstance(item, Query)
            assert decode(Request, item.payload) == request(Pause())
            item.answer(encode(Reply(True)))
        hub.advance(hub.now + 1.0)
        assert [isinstance(item, Response) for item in user.arrivals()] == [True] * answered


def test_who_comes_and_goes_is_seen_by_who_watches_and_an_outage_loses_everybody() -> None:
    hub = MemoryHub()
    watcher, agent = hub.join("x", "watcher"), hub.join("x", "agent")
    watcher.watch()
    agent.appear("agent", 2)
    assert watcher.arrivals() == [Connection(True), Presence("agent", 2, True)]
    hub.disconnect()
    assert watcher.arrivals() == [Presence("agent", 2, False), Connection(False)]
    assert not watcher.connected
    assert not agent.connected
    hub.connect(watcher)
    hub.connect(agent)
    arrived = watcher.arrivals()
    assert arrived[0] == Connection(True)
    assert arrived[-1] == Presence("agent", 2, True)
    agent.close()
    assert watcher.arrivals() == [Presence("agent", 2, False)]


def test_of_several_in_one_place_the_newest_counts_and_the_last_to_go_is_missed() -> None:
    attendance = Attendance()

    def told(session: str, *, here: bool) -> tuple[bool, str] | None:
        found = attendance.note("agent", 2, session, here=here)
        return None if found is None else (found.here, found.session)

    assert told("a", here=True) == (True, "a")
    assert told("a", here=True) is None  # said again after an outage
    assert told("b", here=True) == (True, "b")
    assert told("a", here=True) is None
    assert told("a", here=False) is None
    assert told("c", here=True) == (True, "c")
    assert told("c", here=False) == (True, "b")
    assert told("b", here=False) == (False, "b")
    assert told("b", here=False) is None


def test_nothing_is_carried_while_the_router_is_gone() -> None:
    hub = MemoryHub()
    one, other = joined(hub)
    hub.disconnect()
    perform(one, [Publish(topics.state("x"), state()), Subscribe("x")], ThrottledLog())
    assert not other.arrivals()
    assert one.ask(Pause()) is None
