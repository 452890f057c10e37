"""Files for pages: one at a time, and a page that never answers stops nobody."""

import threading
import time
from types import SimpleNamespace
from typing import Any

import numpy as np

from dashboard.page import Page


class Silent:
    """A page that is asked for its view and never answers."""

    def __init__(self, number: int) -> None:
        self.client_id = number
        self.asked = threading.Event()
        self.answer = threading.Event()
        self.files: list[str] = []
        self.camera = SimpleNamespace(image_height=10, image_width=10)
        line = SimpleNamespace(remove=lambda: None)
        self.scene = SimpleNamespace(add_line_segments=lambda *_, **__: line)

    def get_render(self, *_: object, **__: object) -> Any:
        self.asked.set()
        assert self.answer.wait(10.0)
        return np.zeros((10, 10, 4), dtype=np.uint8)

    def send_file_download(self, name: str, *_: object, **__: object) -> None:
        self.files.append(name)


def test_forty_pictures_that_nobody_answers_hold_one_thread_and_the_next_file_is_made(page: Page) -> None:
    refused = list[int | None]()
    page._export._notify = lambda number, *_: refused.append(number)
    first, others = Silent(0), [Silent(number) for number in range(1, 40)]
    thread = threading.Thread(target=page._export._export, args=("Picture", first))
    thread.start()
    assert first.asked.wait(5.0)
    began = time.monotonic()
    for other in others:
        page._export._export("Picture", other)  # type: ignore[arg-type]
    assert time.monotonic() - began < 1.0
    assert refused == list(range(1, 40))
    first.answer.set()
    thread.join(5.0)
    page._export._export("CSV", others[0])  # type: ignore[arg-type]
    assert (len(first.files), len(others[0].files)) == (1, 1)
