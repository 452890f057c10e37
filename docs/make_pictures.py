"""Makes the pictures of the page beside this file: README's first is cut.png.

.venv/bin/python -m docs.make_pictures [--into FOLDER] [--only RUN] [--chromium /usr/bin/chromium]

Three runs, in a browser without a graphics card: that takes two minutes. The pictures are saved with a palette of 256
colours, which makes them a third as large.
"""

import argparse
import io
from pathlib import Path
from typing import NamedTuple

import numpy as np
from PIL import Image
from playwright.sync_api import Browser, ViewportSize, sync_playwright

from network.control import Clear, SetFault
from tests.browser.browser_run import BrowserRun
from tests.browser.conftest import FLAGS
from tests.browser.driven import Driven

HERE = Path(__file__).parent
SMALL, LARGE = ViewportSize(width=1280, height=720), ViewportSize(width=1920, height=1080)
PLAIN, VIVID, VIVID_FROM = 150, 106, 50
"""Colours of a picture: the most frequent ones, and as many for what has a colour at all, which is little of it."""
APART_SECONDS = 5.0
"""After a cut, until the way that robots were told is used up and they are apart."""
UNSCROLL = "document.querySelectorAll('.mantine-ScrollArea-viewport').forEach(e => { e.scrollTop = 0; })"


class Camera(NamedTuple):
    """What takes the pictures."""

    browser: Browser
    folder: Path

    def take(
        self, driven: Driven, name: str, size: ViewportSize, *, light: bool = False, settle_ms: float = 3000.0
    ) -> None:
        """Save a picture of a page in a window of this size."""
        driven.page.set_viewport_size(size)
        if light:
            driven.tick("Light", True)
        driven.page.evaluate(UNSCROLL)
        driven.page.wait_for_timeout(settle_ms)
        shot = Image.open(io.BytesIO(driven.page.screenshot()))
        if light:
            driven.tick("Light", False)
        path = self.folder / f"{name}.png"
        reduced(shot.convert("RGB")).save(path, optimize=True)


def reduced(picture: Image.Image) -> Image.Image:
    """The picture with 256 colours: greys exactly as they are, and hues as they are seen."""
    pixels = np.asarray(picture).reshape(-1, 3)
    found, counts = np.unique(pixels, axis=0, return_counts=True)
    plain = found[np.argsort(-counts)[:PLAIN]]
    vivid = pixels[np.ptp(pixels.astype(int), axis=1) > VIVID_FROM]
    few = Image.fromarray(vivid[None].copy()).quantize(VIVID, Image.Quantize.MAXCOVERAGE).getpalette() or []
    palette = Image.new("P", (1, 1))
    palette.putpalette([*plain.ravel().tolist(), *few[: 3 * VIVID]])
    return picture.quantize(palette=palette, dither=Image.Dither.NONE)


def followed(camera: Camera) -> None:
    """A square of which robot 1 alone knows the path: healthy, cut, rewound."""
    with BrowserRun("follow-the-leader", robots=4) as run:
        driven = Driven(camera.browser, run.url, width=LARGE["width"], height=LARGE["height"])
        driven.wait_text(r"t = \d\d+\.", 90.0)
        camera.take(driven, "healthy", SMALL)
        camera.take(driven, "healthy-light", LARGE, light=True)
        driven.page.set_viewport_size(LARGE)
        driven.page.wait_for_timeout(3000)
        before = run.state().stamp
        run.ask(SetFault(link="1->2", changes={"cut": True}))
        while run.state().stamp < before + APART_SECONDS:
            driven.page.wait_for_timeout(100)
        camera.take(driven, "cut", LARGE, settle_ms=600)
        run.ask(Clear())
        driven.page.wait_for_timeout(14_000)
        run.ask(SetFault(link="3->4", changes={"latency": 0.3, "loss": 0.2}))
        driven.page.wait_for_timeout(6000)
        run.ask(Clear())
        driven.page.wait_for_timeout(6000)
        driven.press("Event before")
        driven.page.wait_for_timeout(1000)
        driven.press("Event before")
        driven.page.wait_for_timeout(1000)
        for _ in range(6):
            driven.page.locator(".e-handle").press("ArrowRight")
            driven.page.wait_for_timeout(300)
        camera.take(driven, "rewound", LARGE)
        driven.page.locator(".e-live").click()
        driven.wait_text("● LIVE")
        driven.show("Ledger")
        driven.wait_text("Excursions")
        driven.page.locator("[data-cell^=excursion]").last.dispatch_event("pointerdown")
        driven.wait_text("How it came")
        camera.take(driven, "ledger", SMALL)


def drove(camera: Camera) -> None:
    """A formation that a user drives."""
    with BrowserRun("drive-me", robots=4) as run:
        driven = Driven(camera.browser, run.url, width=SMALL["width"], height=SMALL["height"])
        driven.wait_text("Nobody has the wheel", 60.0)
        driven.press("Take the wheel")
        driven.page.wait_for_function("() => Boolean(window.__echelonWheel)", polling=100)
        driven.page.keyboard.down("w")
        driven.page.keyboard.down("a")
        driven.until(lambda: run.state().driving.orders > 3, "orders")
        driven.page.wait_for_timeout(4000)
        camera.take(driven, "driven", SMALL, settle_ms=600)
        driven.page.keyboard.up("w")
        driven.page.keyboard.up("a")


def looked_into(camera: Camera) -> None:
    """The Network tab while a link is late and lossy."""
    with BrowserRun("square-figure8", robots=4) as run:
        driven = Driven(camera.browser, run.url, width=SMALL["width"], height=SMALL["height"])
        driven.wait_text(r"t = \d\d+\.", 60.0)
        run.ask(SetFault(link="2->3", changes={"latency": 0.35, "jitter": 0.1, "loss": 0.3}))
        driven.click_cell("link 2")
        driven.show("Network")
        driven.page.wait_for_timeout(25_000)
        camera.take(driven, "network", SMALL)
        camera.take(driven, "network-light", LARGE, light=True)


RUNS = (followed, drove, looked_into)


def main() -> None:
    """Make them all."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--into", type=Path, default=HERE)
    parser.add_argument("--only", choices=[run.__name__ for run in RUNS], help="one of the runs")
    parser.add_argument("--chromium", default="/usr/bin/chromium")
    options = parser.parse_args()
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=options.chromium, args=FLAGS)
        for pictures in RUNS:
            if options.only in (None, pictures.__name__):
                pictures(Camera(browser, options.into))
        browser.close()


if __name__ == "__main__":
    main()
