"""Laws of the throttled log: everything is counted, a second holds one line per subject, and memory has a bound."""

import pytest

from network import throttled_log
from network.throttled_log import LOG_INTERVAL, MAX_SUBJECTS, ThrottledLog


class Clock:
    def __init__(self) -> None:
        self.now = 0.0

    def __call__(self) -> float:
        return self.now


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> Clock:
    made = Clock()
    monkeypatch.setattr(throttled_log, "monotonic", made)
    return made


def test_a_second_holds_one_line_per_key_and_the_next_tells_how_many_were_skipped(
    clock: Clock, caplog: pytest.LogCaptureFixture
) -> None:
    log = ThrottledLog()
    for _ in range(5):
        log.add("a", "not a message")
    log.add("b", "not a message")
    assert len(caplog.messages) == 2
    clock.now = LOG_INTERVAL
    log.add("a", "not a message")
    assert log.count == 7
    assert "on a: not a message (and 4 more" in caplog.messages[-1]


def test_an_exception_is_logged_with_its_traceback(clock: Clock, caplog: pytest.LogCaptureFixture) -> None:
    log = ThrottledLog()
    for _ in range(3):
        try:
            raise IndexError("odd value")
        except IndexError:
            log.add_exception("drawing a frame")
    assert log.count == 3
    (record,) = caplog.records
    assert "drawing a frame" in record.getMessage()
    assert record.exc_info is not None
    assert isinstance(record.exc_info[1], IndexError)


def test_a_flood_of_invented_keys_does_not_fill_the_memory(clock: Clock) -> None:
    log = ThrottledLog()
    for number in range(3 * MAX_SUBJECTS):
        log.add(f"key {number}", "not a message")
    assert log.count == 3 * MAX_SUBJECTS
    assert len(log._logged) <= MAX_SUBJECTS + 1
