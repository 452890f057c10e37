"""Laws of the page's loop."""

import logging
import time

import numpy as np
import pytest

from dashboard.page import UNWATCHED_FRAME, Page
from network import topics
from network.codec import encode
from tests.builders import state
from tests.dashboard.fakes import receive


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
