"""Laws of the page's loop."""

import gc
import logging
import time
import weakref

import numpy as np
import pytest

from dashboard.pacing import UNWATCHED_FRAME
from dashboard.page import Page
from dashboard.panels.run_summary import condition
from dashboard.serving import server
from dashboard.serving.access import Guard
from formation.scenario.files import load
from network import topics
from network.bus import Incoming, Query
from network.codec import decode, encode
from network.control import Pause, Start, operation
from network.memory_bus import MemoryHub
from network.requests import Reply, Request, Setup
from tests.builders import state
from tests.dashboard.fakes import edit, receive


def test_a_frame_that_cannot_be_drawn_does_not_end_the_page(
    page: Page, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    drawn: list[int] = []

    def frame() -> int:
        drawn.append(len(drawn))
        if len(drawn) <= 3:
            raise IndexError("odd value")
        return 3

    monkeypatch.setattr(page, "_frame", frame)

    class _Lifetime:
        @property
        def over(self) -> bool:
            return len(drawn) >= 6

    page.serve(_Lifetime())  # type: ignore[arg-type]
    assert len(drawn) == 6
    errors = [record for record in caplog.records if record.levelno == logging.ERROR]
    assert len(errors) == 1, "once a second"
    assert "drawing a frame" in errors[0].getMessage()


def test_without_an_open_page_every_state_is_kept_and_few_are_drawn(
    page: Page, monkeypatch: pytest.MonkeyPatch
) -> None:
    drawn: list[float] = []
    draw = page._frame

    def frame() -> int:
        drawn.append(time.monotonic())
        return draw()

    class _Lifetime:
        """Some moments, in each of which the world says something."""

        moments = 0

        @property
        def over(self) -> bool:
            self.moments += 1
            assert receive(page._feed.source, topics.state("x"), encode(state(stamp=1.0 + 0.2 * self.moments)))
            return self.moments > 25

    monkeypatch.setattr(page, "_frame", frame)
    page.serve(_Lifetime())  # type: ignore[arg-type]
    kept = page._feed.export_buffer.data()
    assert kept is not None
    assert len(kept.t) >= 25, "every moment"
    assert drawn
    assert (np.diff(drawn) >= UNWATCHED_FRAME).all()


def test_what_a_page_that_is_gone_has_left_is_freed(page: Page) -> None:
    class Left:
        """Refers to itself, as viser's objects of a page do."""

        def __init__(self) -> None:
            self.itself = self

    gc.disable()
    try:
        left = weakref.ref(Left())
        page._collect()
        assert left() is not None
        page._closed(edit(0).client)
        page._collect()
        assert left() is None
    finally:
        gc.enable()


def test_two_dashboards_of_one_run_show_the_same_and_both_may_ask() -> None:
    hub = MemoryHub()
    world = hub.join("x")
    world.serve(topics.control("x"))
    world.serve(topics.question("x"))
    world.announce(topics.state("x"))
    setup = Setup(0, 0, 0.0, 0, 0, load("triangle-circle").model_dump_json(exclude_unset=True), "lockstep", {})

    def react(item: Incoming) -> None:
        assert isinstance(item, Query)
        if item.key == topics.question("x"):
            item.answer(encode(setup))
            return
        status = "paused" if operation(decode(Request, item.payload)) == Pause() else "running"
        item.answer(encode(Reply(True)))
        world.publish(topics.state("x"), state(stamp=2.0, status=status))

    world.react = react
    served = [server.serve(Guard("127.0.0.1"), 0, "x") for _ in range(2)]
    pages = [Page(each, hub.join("x")) for each in served]
    for page in pages:
        page._feed.source.start()
    for asked, (wish, label) in enumerate(((Pause(), "PAUSED"), (Start(), "RUNNING"))):
        pages[asked]._requests._do(wish)  # type: ignore[arg-type]
        end = time.monotonic() + 20.0
        while {condition(page._feed.now().snapshot).label for page in pages} != {label}:
            assert time.monotonic() < end
            time.sleep(0.01)
    for page, each in zip(pages, served, strict=True):
        page._feed.source.stop()
        server.stop(each)
