"""Laws of edits: what a user sets arrives as it was set, in order, whatever the program writes meanwhile."""

import asyncio
import contextlib
import sys
import threading
from collections.abc import Iterator
from itertools import cycle
from typing import Any

import pytest

from dashboard.edits import Edit, on_edit, set_value
from dashboard.panels.mirrored_controls import MirroredControl, set_options
from tests.dashboard.serving.hostile import camera
from tests.dashboard.serving.served import Served, send, update

EDITS = 40


@pytest.fixture
def frequent(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Threads change places as often as can be; a user's value is not held."""
    before = sys.getswitchinterval()
    sys.setswitchinterval(1e-6)
    yield
    sys.setswitchinterval(before)


def _edited(served: Served, uuid: str, values: list[Any], seen: list[Any]) -> None:
    """A page sets a control to these values, one after another, and stays until so many edits were seen."""

    async def edit() -> None:
        async with served.page() as page:
            await send(page, camera())
            for value in values:
                await send(page, update(uuid, value))
                await asyncio.sleep(0.005)
            while len(seen) < len(values):
                await asyncio.sleep(0.01)

    with contextlib.suppress(TimeoutError):  # what is missing then, the test tells
        asyncio.run(asyncio.wait_for(edit(), 30.0))


def test_every_edit_arrives_as_it_was_set_and_in_order_while_the_program_writes(served: Served, frequent: None) -> None:
    slider, seen, over = served.controls["slider"], list[float](), threading.Event()
    mirrored = MirroredControl(slider)

    def handler(edit: Edit) -> None:
        seen.append(edit.value)
        mirrored.release()  # the program may write again at once

    def draw() -> None:
        for value in cycle((0.2, 0.4)):
            if over.is_set():
                return
            mirrored.show(value)
            over.wait(0.001)

    on_edit(slider, handler)
    drawing = threading.Thread(target=draw)
    drawing.start()
    values = [1.0 + 0.1 * (n % 80) for n in range(EDITS)]
    try:
        _edited(served, served.uuids["slider"], values, seen)
    finally:
        over.set()
        drawing.join()
    assert seen == pytest.approx(values)


def test_a_choice_arrives_while_the_options_change(served: Served, frequent: None) -> None:
    dropdown, seen, over = served.controls["dropdown"], list[str](), threading.Event()

    def handler(edit: Edit) -> None:
        seen.append(edit.value)
        set_value(dropdown, "a")

    def draw() -> None:
        for last in cycle("cd"):
            if over.is_set():
                return
            set_options(dropdown, ("a", "b", last))
            over.wait(0.001)

    on_edit(dropdown, handler)
    drawing = threading.Thread(target=draw)
    drawing.start()
    try:
        _edited(served, served.uuids["dropdown"], ["b"] * EDITS, seen)
    finally:
        over.set()
        drawing.join()
    assert seen == ["b"] * EDITS


def test_what_the_program_writes_is_no_edit(served: Served) -> None:
    seen: list[Any] = []
    for name in ("slider", "checkbox", "dropdown"):
        on_edit(served.controls[name], seen.append)
    served.controls["slider"].value = 5.0
    set_value(served.controls["dropdown"], "b")
    _edited(served, served.uuids["checkbox"], [True], seen)
    assert [edit.value for edit in seen] == [True]
    assert served.controls["dropdown"].value == "b"


def test_a_slow_handler_holds_up_no_other(served: Served) -> None:
    order, waits = list[str](), threading.Event()

    def slow(edit: Edit) -> None:
        waits.wait(10.0)
        order.append(f"slow {edit.value}")

    on_edit(served.controls["checkbox"], slow, slow=True)
    on_edit(served.controls["slider"], lambda edit: order.append("quick"))

    async def edit() -> None:
        async with served.page() as page:
            await send(page, camera(), update(served.uuids["checkbox"], True), update(served.uuids["slider"], 3.0))
            while "quick" not in order:
                await asyncio.sleep(0.01)
            waits.set()
            while len(order) < 2:
                await asyncio.sleep(0.01)

    asyncio.run(asyncio.wait_for(edit(), 20.0))
    assert order == ["quick", "slow True"]
