"""Laws of a session: what is kept waits for whoever looks, the newest so many, in order."""

import threading
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from network import topics
from network.bus import Kept, Sample
from network.codec import decode
from network.messages import Command
from network.zenoh_bus import Router, ZenohBus


@pytest.fixture
def pair(tmp_path: Path) -> Iterator[tuple[ZenohBus, ZenohBus]]:
    """Two clients of one router."""
    endpoint = f"unixsock-stream/{tmp_path}/r"
    router = Router([endpoint])
    with ZenohBus(endpoint, "x") as one, ZenohBus(endpoint, "x") as other:
        yield one, other
    router.close()


def say(session: ZenohBus, numbers: range) -> None:
    for seq in numbers:
        session.publish(topics.command("x", 1), Command(1, seq, 0.0, 0, 0.0, 0.0, 0.0, False, 0.0))


def heard(kept: Kept, least: int) -> list[Sample]:
    """What has come in once there is so much of it."""
    found: list[Sample] = []
    end = time.monotonic() + 20.0
    while len(found) < least and time.monotonic() < end:
        found += kept.take()
        time.sleep(0.01)
    return found


def test_what_is_kept_comes_once_and_in_order_and_never_in_the_inbox(pair: tuple[ZenohBus, ZenohBus]) -> None:
    sender, listener = pair
    kept = listener.keep(topics.command("x", "*"), 100)
    sender.announce(topics.command("x", 1), reliable=True)
    time.sleep(0.2)
    say(sender, range(20))
    found = heard(kept, 20)
    assert [decode(Command, sample.payload).seq for sample in found] == list(range(20))
    assert {sample.key for sample in found} == {topics.command("x", 1)}
    assert list(kept.take()) == []
    assert listener.inbox.empty()


def test_of_what_nobody_looked_at_in_time_the_newest_is_left(pair: tuple[ZenohBus, ZenohBus]) -> None:
    sender, listener = pair
    kept, all_of_it = listener.keep(topics.command("x", 1), 3), listener.keep(topics.command("x", 1), 1000)
    sender.announce(topics.command("x", 1), reliable=True)
    time.sleep(0.2)
    say(sender, range(50))
    every = heard(all_of_it, 50)
    assert list(kept.take()) == every[-3:]


def test_what_is_too_large_for_a_message_arrives_as_no_message(
    pair: tuple[ZenohBus, ZenohBus], monkeypatch: pytest.MonkeyPatch
) -> None:
    sender, listener = pair
    kept = listener.keep(topics.command("x", 1), 100)
    sender.announce(topics.command("x", 1), reliable=True)
    time.sleep(0.2)
    say(sender, range(1))
    size = len(heard(kept, 1)[0].payload)
    monkeypatch.setattr("network.zenoh_bus.MAX_BYTES", size - 1)
    say(sender, range(1))
    assert heard(kept, 1)[0].payload == b""


def test_python_keeps_its_state_of_the_thread_that_receives(
    pair: tuple[ZenohBus, ZenohBus], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Memory was mapped for one and unmapped at each message: a page fault each, and a tenth of the processor time."""
    sender, listener = pair
    here, counts = threading.local(), list[int]()

    def put(_: object, *, quietly: bool) -> None:
        del quietly
        here.count = getattr(here, "count", 0) + 1
        counts.append(here.count)

    monkeypatch.setattr(listener.inbox, "put", put)
    listener.subscribe(topics.command("x", 1))
    sender.announce(topics.command("x", 1), reliable=True)
    time.sleep(0.2)
    say(sender, range(20))
    end = time.monotonic() + 20.0
    while len(counts) < 20 and time.monotonic() < end:
        time.sleep(0.01)
    assert max(counts) > 10, "a thread that is forgotten counts from 1"


def test_what_is_packed_arrives_as_it_would_alone(pair: tuple[ZenohBus, ZenohBus]) -> None:
    """Bursts of several senders' messages, of all sizes: each whole, once, in the order of its key."""
    sender, listener = pair
    keys = [topics.command("x", robot) for robot in range(1, 17)]
    for reliable in (True, False):
        run = 100 * reliable
        for key in keys:
            sender.announce(key, reliable=reliable, packed=True)
        kept = [listener.keep(key, 1000) for key in keys]
        time.sleep(0.5)
        for seq in range(30):
            for robot, key in enumerate(keys, 1):
                failure = "x" * (17 * seq * robot % 4000)
                sender.publish(key, Command(robot, run + seq, 0.0, 0, 0.1, 0.2, 0.0, False, 0.0, failure=failure))
            time.sleep(0.002)
        for robot, one in enumerate(kept, 1):
            found = [decode(Command, sample.payload) for sample in heard(one, 30)]
            seqs = [message.seq - run for message in found]
            assert seqs == (list(range(30)) if reliable else sorted(set(seqs))), "what is not reliable may be lost"
            assert {message.sender for message in found} == {robot}
            assert [len(message.failure) for message in found] == [17 * seq * robot % 4000 for seq in seqs]


def test_what_is_packed_does_not_wait_for_more(pair: tuple[ZenohBus, ZenohBus]) -> None:
    """It goes out at once if nothing else does; within a second, where the machine has other work."""
    sender, listener = pair
    listener.subscribe(topics.command("x", 1))
    sender.announce(topics.command("x", 1), reliable=True, packed=True)
    time.sleep(0.5)
    ways = []
    for seq in range(20):
        began = time.monotonic()
        say(sender, range(seq, seq + 1))
        assert listener.arrivals(20.0)
        ways.append(time.monotonic() - began)
    assert sorted(ways)[10] < 0.05
