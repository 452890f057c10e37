"""Laws of requests to the world: none is lost, their order is kept, and a refusal reaches its page."""

import time
from collections.abc import Callable

import pytest

from dashboard.requests import RequestQueue
from network.bus import Bus
from network.control import Drive, Pause, SetFault
from network.requests import Reply
from tests.dashboard.fakes import FakeTelemetry, world


def request_queue(session: Bus, shown: list[str]) -> RequestQueue:
    requests = RequestQueue(session, FakeTelemetry(), lambda page, title, text: shown.append(f"{page} {title}: {text}"))  # type: ignore[arg-type]
    requests.start()
    return requests


def wait_until(holds: Callable[[], bool]) -> None:
    end = time.monotonic() + 20.0
    while not holds():
        assert time.monotonic() < end
        time.sleep(0.01)


def test_a_refusal_is_shown_on_the_page_that_asked() -> None:
    shown: list[str] = []
    requests = request_queue(world(Reply(False, "latency: too long"))[0], shown)
    requests.ask(Pause(), 3)
    wait_until(lambda: shown == ["3 Not done: latency: too long"])
    requests.stop()


def test_a_missing_reply_is_shown() -> None:
    shown: list[str] = []
    requests = request_queue(world(None)[0], shown)
    requests.ask(Pause(), 3)
    wait_until(lambda: len(shown) == 1 and "No answer: The world did not answer" in shown[0])
    requests.stop()


def test_a_router_that_is_gone_is_shown_as_such() -> None:
    shown: list[str] = []
    session, asked = world(Reply(True))
    session.up = False
    requests = request_queue(session, shown)
    requests.ask(Pause(), 3)
    wait_until(lambda: len(shown) == 1 and "The network is gone" in shown[0])
    requests.stop()
    assert not asked


def test_an_error_without_a_text_does_not_end_the_thread(
    caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    def broken(*_: object) -> None:
        raise RuntimeError

    shown: list[str] = []
    session, _ = world(Reply(True))
    monkeypatch.setattr(session, "fetch", broken)
    requests = request_queue(session, shown)
    requests.ask(Pause(), 3)
    requests.ask(Pause(), None)
    wait_until(lambda: len(shown) == 2)
    requests.stop()
    assert shown == [f"{page} The request could not be sent: RuntimeError" for page in (3, None)]
    assert len(caplog.records) == 1


def test_of_a_dragged_slider_only_the_last_value_is_requested_and_in_order() -> None:
    session, asked = world(Reply(True))
    requests = request_queue(session, [])
    for loss in (0.1, 0.2, 0.3):
        requests.change(("1->2", "2->3"), {"loss": loss}, None, 1)
    requests.ask(Pause(), 1)
    wait_until(lambda: len(asked) == 3)
    requests.stop()
    assert asked[:2] == [SetFault(link=link, changes={"loss": 0.3}) for link in ("1->2", "2->3")]
    assert asked[2] == Pause()


def test_of_orders_that_wait_the_newest_is_sent() -> None:
    """A page says ten times a second what is held; a world that answers late gets the last word, not the first ones."""
    session, asked = world(Reply(True))
    requests = RequestQueue(session, FakeTelemetry(), lambda *_: None)  # type: ignore[arg-type]
    for v in (0.1, 0.2, 0.3):
        requests.steer(Drive(v=v, omega=0.0, seconds=0.3), 1)
    requests.start()
    wait_until(lambda: bool(asked))
    requests.steer(Drive(v=0.0, omega=0.0, seconds=0.3), 1)
    wait_until(lambda: len(asked) == 2)
    requests.stop()
    assert [order.v for order in asked if isinstance(order, Drive)] == [0.3, 0.0]
