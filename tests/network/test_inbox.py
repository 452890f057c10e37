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
