"""The queue of what has come in: its order, its time limit, and that no reader sleeps while something is there."""

import threading
from itertools import count
from queue import Empty
from time import monotonic

import pytest

from network import inbox
from network.inbox import Inbox


def test_first_in_first_out() -> None:
    box: Inbox[int] = Inbox()
    for i in range(5):
        box.put(i)
    assert [box.get(), box.get_nowait(), box.get(timeout=1.0), box.get(), box.get()] == [0, 1, 2, 3, 4]
    assert box.empty()
    with pytest.raises(Empty):
        box.get_nowait()


@pytest.mark.parametrize("rung", [False, True], ids=["new", "what came in is gone"])
def test_a_limit_that_is_over_before_the_reader_waits_is_a_limit(monkeypatch: pytest.MonkeyPatch, rung: bool) -> None:
    box: Inbox[int] = Inbox()
    if rung:
        box.put(1)
        assert box.get_nowait() == 1
    clock = count(100.0, 5.0)  # the reader loses its processor for 5 s whenever it can
    monkeypatch.setattr(inbox, "monotonic", lambda: next(clock))
    found: list[object] = []

    def read() -> None:
        try:
            found.append(box.get(timeout=0.01))
        except Empty as error:
            found.append(error)

    reader = threading.Thread(target=read, daemon=True)
    reader.start()
    reader.join(10.0)
    assert [type(each) for each in found] == [Empty]


def test_nothing_comes_in_for_as_long_as_the_limit() -> None:
    box: Inbox[int] = Inbox()
    box.put(1)
    box.get()
    began = monotonic()
    with pytest.raises(Empty):
        box.get(timeout=0.05)
    assert monotonic() - began >= 0.05


def test_many_writers_and_a_reader_lose_nothing_and_the_reader_never_sleeps_on() -> None:
    box: Inbox[tuple[int, int]] = Inbox()
    each, writers = 5000, 4

    def write(writer: int) -> None:
        for i in range(each):
            box.put((writer, i))

    threads = [threading.Thread(target=write, args=(writer,)) for writer in range(writers)]
    for thread in threads:
        thread.start()
    found: dict[int, list[int]] = {writer: [] for writer in range(writers)}
    for _ in range(each * writers):
        writer, i = box.get(timeout=20.0)
        found[writer].append(i)
    for thread in threads:
        thread.join()
    assert all(numbers == list(range(each)) for numbers in found.values())


def test_a_reader_is_woken() -> None:
    box: Inbox[int] = Inbox()
    for i in range(200):  # each time it may be waiting already, or not yet
        writer = threading.Thread(target=box.put, args=(i,))
        writer.start()
        assert box.get(timeout=20.0) == i
        writer.join()


def test_quiet_items_wake_the_reader_when_they_are_enough() -> None:
    box: Inbox[int] = Inbox()
    found: list[int] = []

    def read() -> None:
        found.append(box.get(20.0, enough=3))

    reader = threading.Thread(target=read)
    reader.start()
    for i in range(2):
        box.put(i, quietly=True)
    reader.join(0.05)
    assert reader.is_alive()
    box.put(2, quietly=True)
    reader.join(20.0)
    assert found == [0]


@pytest.mark.parametrize("early", [False, True], ids=["while it waits", "before it waits"])
def test_any_other_item_wakes_the_reader_at_once(early: bool) -> None:
    box: Inbox[int] = Inbox()
    box.put(0, quietly=True)
    found: list[int] = []

    def read() -> None:
        found.append(box.get(20.0, enough=100))

    if early:
        box.put(1)
    reader = threading.Thread(target=read)
    reader.start()
    if not early:
        reader.join(0.02)
        assert reader.is_alive()
        box.put(1)
    reader.join(10.0)
    assert found == [0]
    assert box.get_nowait() == 1


def test_for_what_is_left_nobody_waits_again() -> None:
    box: Inbox[int] = Inbox()
    for i in range(3):
        box.put(i, quietly=i != 2)
    assert box.get(20.0, enough=100) == 0
    assert box.ready(100)
    assert [box.get(20.0, enough=100), box.get(20.0, enough=100)] == [1, 2]
    box.put(3, quietly=True)
    assert not box.ready(2)


def test_after_the_limit_fewer_are_enough() -> None:
    box: Inbox[int] = Inbox()
    box.put(0, quietly=True)
    began = monotonic()
    assert box.get(0.05, enough=2) == 0
    assert monotonic() - began >= 0.05
    with pytest.raises(Empty):
        box.get(0.01, enough=2)


def test_many_quiet_writers_and_a_reader_that_waits_for_all_of_them() -> None:
    box: Inbox[int] = Inbox()
    rounds, writers = 500, 4
    gates = [threading.Semaphore(0) for _ in range(writers)]

    def write(writer: int) -> None:
        for _ in range(rounds):
            gates[writer].acquire()
            box.put(writer, quietly=True)

    threads = [threading.Thread(target=write, args=(writer,)) for writer in range(writers)]
    for thread in threads:
        thread.start()
    began = monotonic()
    for _ in range(rounds):
        for gate in gates:
            gate.release()
        found = [box.get(5.0, enough=writers)] + [box.get_nowait() for _ in range(writers - 1)]
        assert sorted(found) == list(range(writers))
    assert monotonic() - began < rounds * 0.5  # never to the limit
    for thread in threads:
        thread.join()
