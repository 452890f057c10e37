"""A record on the page: it plays, is dragged and stepped, and nothing of it can be changed."""

import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest

from tests.browser.browser_run import ROOT
from tests.browser.driven import Driven
from tests.records.recorded import record, scenario

if TYPE_CHECKING:
    from playwright.sync_api import Browser

pytestmark = [pytest.mark.browser, pytest.mark.processes]


@pytest.fixture
def page(browser: "Browser", tmp_path: Path) -> Iterator[Driven]:
    files = [tmp_path / "one.mcap", tmp_path / "other.mcap"]
    record(files[0], scenario())
    record(files[1], scenario("faults=[]"))
    command = [sys.executable, "-m", "cli.main", "replay", *map(str, files), "--port", "0"]
    served = subprocess.Popen(command, cwd=ROOT, text=True, stdout=subprocess.PIPE)
    try:
        assert served.stdout is not None
        driven = Driven(browser, served.stdout.readline().split()[-1])
        yield driven
        driven.page.close()
    finally:
        served.terminate()
        served.wait(10.0)
        if served.stdout is not None:
            served.stdout.close()


def test_a_record_is_played_dragged_and_compared_and_cannot_be_changed(page: Driven) -> None:
    page.wait_text("RECORD")
    page.wait_text(r"✕ 1→2 cut", 30.0)
    page.wait_text(r"of 2\.\d s")
    page.wait_text(r"(?s)RMS, 2 s.*distance.*tracking", 30.0)
    box = page.page.locator(".e-track").bounding_box()
    assert box is not None
    page.page.mouse.click(box["x"] + 0.7 * box["width"], box["y"] + 50)
    page.wait_text(r"t = 1\.[78] s")
    page.wait_text(r"1→2\s+.*cut")
    before = page.bodies()
    page.page.locator(".e-handle").press("ArrowLeft")
    page.until(lambda: bool(np.abs(page.bodies() - before).max() > 1e-2), "a second before")
    page.wait_text(r"t = 0\.[78] s")
    page.press("Play")
    page.wait_text(r"t = 2\.[345] s", 20.0)
    page.until(lambda: page.page.get_by_role("button", name="Play", exact=True).count() == 1, "the end")
    assert page.page.locator(page._id("Cut")).is_disabled()
    page.show("Robots")
    page.click_cell("kill 1")
    page.wait_text("This is a record")
    assert page.errors == []
