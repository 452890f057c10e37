"""The dashboard's page as a test drives it: by the texts that a user reads, and by viser's own test hooks."""

import re
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from formation.arrays import FloatArray

if TYPE_CHECKING:
    from playwright.sync_api import Browser, ConsoleMessage, Locator, Page, Request

THROTTLE_MS = 80
"""The page drops edits that follow each other faster than 50 ms."""
READY = """() => {
  const t = window.__viserTestpoints, m = window.__viserMutable;
  return t && t.rendererInfo && t.rendererInfo.render.frame > 1 && window.__viserSceneTree
    && window.__viserSceneTree.getState()["/bodies"] !== undefined;
}"""
LIGHTER = """(() => {
  const context = HTMLCanvasElement.prototype.getContext, frame = window.requestAnimationFrame.bind(window), held = [];
  HTMLCanvasElement.prototype.getContext = function (kind, options) {
    return context.call(this, kind, kind.startsWith("webgl") ? {...options, antialias: false} : options);
  };
  let rests = false;
  window.requestAnimationFrame = draw => frame(now => rests ? held.push(draw) : draw(now));
  window.__rest = on => { rests = on; if (!on) held.splice(0).forEach(draw => window.requestAnimationFrame(draw)); };
})()"""
"""Smooth edges are a third of a frame when the processor draws it; a page that rests leaves it to another one."""
PIXEL = """([x, y, z]) => {
  const camera = window.__viserMutable.camera, canvas = window.__viserMutable.canvas;
  const apply = (m, v) => [0, 1, 2, 3].map(r => m[r] * v[0] + m[r + 4] * v[1] + m[r + 8] * v[2] + m[r + 12] * v[3]);
  const node = window.__viserMutable.nodeRefFromName["/bodies"];
  const point = apply((node.current || node).matrixWorld.elements, [x, y, z, 1]);
  const clip = apply(camera.projectionMatrix.elements, apply(camera.matrixWorldInverse.elements, point));
  const flat = document.createElement("canvas");
  flat.width = canvas.width; flat.height = canvas.height;
  const context = flat.getContext("2d");
  context.drawImage(canvas, 0, 0);
  const u = Math.round((clip[0] / clip[3] + 1) / 2 * canvas.width);
  const v = Math.round((1 - clip[1] / clip[3]) / 2 * canvas.height);
  return [u, v, ...context.getImageData(u, v, 1, 1).data.slice(0, 3)];
}"""


def frames(page: "Page") -> int:
    """Frames that a page has drawn so far."""
    return int(page.evaluate("window.__viserTestpoints.rendererInfo.render.frame"))


class Driven:
    """One page of the dashboard."""

    def __init__(
        self, browser: "Browser", url: str, *, token: str | None = None, width: int = 1120, height: int = 640
    ) -> None:
        """Open it in a window of this size, with a token if it requires one."""
        self.url, self._token = url, token
        self.errors: list[str] = []
        self.requests: list[str] = []
        self.page = browser.new_page(viewport={"width": width, "height": height})
        self.page.add_init_script(LIGHTER)
        self.page.on("console", self._note_console)
        self.page.on("pageerror", lambda error: self.errors.append(str(error)))
        self.page.on("request", self._note_request)
        self.open(url)

    def _note_console(self, message: "ConsoleMessage") -> None:
        if message.type == "error":
            self.errors.append(message.text)

    def _note_request(self, request: "Request") -> None:
        self.requests.append(request.url)

    def open(self, url: str) -> None:
        """Load the page and wait until it shows robots."""
        self.url = url
        self.page.goto(f"{url}/?fixedDpr=1" + (f"&token={self._token}" if self._token else ""))
        self.page.wait_for_function(READY, timeout=120_000, polling=100)

    @contextmanager
    def at_rest(self) -> Iterator[None]:
        """It draws nothing meanwhile."""
        self.page.evaluate("window.__rest(true)")
        yield
        self.page.evaluate("window.__rest(false)")

    @property
    def frames(self) -> int:
        """Frames drawn so far."""
        return frames(self.page)

    def text(self) -> str:
        """All text on the page."""
        return self.page.locator("body").inner_text()

    def wait_text(self, pattern: str, seconds: float = 20.0) -> None:
        """Wait for a text."""
        self.until(lambda: re.search(pattern, self.text()) is not None, f"text {pattern!r}", seconds)

    def until(self, holds: Callable[[], bool], what: str, seconds: float = 20.0) -> None:
        """Wait until it holds."""
        end = time.monotonic() + seconds
        while not holds():
            assert time.monotonic() < end, f"no {what} within {seconds:g} s; the page reads: {self.text()[:1500]}"
            self.page.wait_for_timeout(60)

    def press(self, name: str) -> None:
        """Click a button."""
        _click(self.page.get_by_role("button", name=name, exact=True))
        self.page.wait_for_timeout(THROTTLE_MS)

    def click_cell(self, name: str) -> None:
        """Click a cell of a table, such as "link 2" or "kill 1"."""
        cell = self.page.locator(f'[data-click][data-cell="{name}"]')
        cell.wait_for(state="attached", timeout=20_000)
        cell.dispatch_event("pointerdown")
        self.page.wait_for_timeout(THROTTLE_MS)

    def show(self, tab: str) -> None:
        """Open a tab of the right panel."""
        self.page.get_by_role("tab", name=tab, exact=True).click(force=True)

    def take(self, name: str, into: Path) -> Path:
        """Click a button that sends a file, and save it."""
        with self.page.expect_download(timeout=60_000) as download:
            self.press(name)
        path = into / download.value.suggested_filename
        download.value.save_as(path)
        return path

    @property
    def theme(self) -> str:
        """Theme of the panels: "dark" or "light"."""
        return str(self.page.locator("html").get_attribute("data-mantine-color-scheme"))

    @property
    def plots_are_whole(self) -> bool:
        """Whether every plot shows all of its time axis, with several points in it."""
        return bool(
            self.page.evaluate(
                """() => Object.values(window.__viserTestpoints.uplots).every(({chart}) => {
                  const t = chart.data[0], x = chart.scales.x;
                  return t.length > 2 && Math.abs(x.min - t[0]) + Math.abs(x.max - t[t.length - 1]) < 1;
                })"""
            )
        )

    @property
    def lost(self) -> bool:
        """Whether the page shows that its server is gone."""
        return "waits" in self.page.evaluate("getComputedStyle(document.body, '::after').content")

    def _id(self, label: str) -> str:
        found = self.page.locator(f'label:text-is("{label}")').get_attribute("for")
        assert found is not None
        return f'[id="{found}"]'

    def choose(self, label: str, option: str) -> None:
        """Choose from a dropdown."""
        _click(self.page.locator(self._id(label)))
        _click(self.page.get_by_role("option", name=option, exact=True))
        self.page.wait_for_timeout(THROTTLE_MS)

    def chosen(self, label: str) -> str:
        """Value of a dropdown."""
        return self.page.locator(self._id(label)).input_value()

    def tick(self, label: str, on: bool) -> None:
        """Set a checkbox."""
        box = self.page.locator(self._id(label))
        if box.is_checked() != on:
            _click(box)
        self.page.wait_for_timeout(THROTTLE_MS)

    def ticked(self, label: str) -> bool:
        """Whether a checkbox is set."""
        return self.page.locator(self._id(label)).is_checked()

    def _number_box(self, label: str) -> Any:
        return self.page.locator(self._id(label)).locator("xpath=following-sibling::*//input")

    def fill(self, label: str, value: str) -> None:
        """Type into a slider's number box."""
        box = self._number_box(label)
        box.fill(value)
        box.blur()
        self.page.wait_for_timeout(THROTTLE_MS)

    def number(self, label: str) -> str:
        """Text in a slider's number box."""
        return str(self._number_box(label).input_value())

    def prop(self, node: str, name: str) -> FloatArray:
        """An array of the scene as the page has it."""
        value = self.page.evaluate(
            "([node, name]) => Array.from(window.__viserSceneTree.getState()[node].message.props[name])", [node, name]
        )
        return np.array(value, dtype=float)

    def bodies(self) -> FloatArray:
        """(n, 3) where the page draws the robots [m]."""
        return self.prop("/bodies", "batched_positions").reshape(-1, 3)

    def pixel(self, point: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Place on the canvas and colour (0..255) of a point of the world."""
        u, v, r, g, b = self.page.evaluate(PIXEL, [float(c) for c in point])
        return np.array([u, v]), np.array([r, g, b], dtype=float)

    def age(self, sender: int, receiver: int) -> float | None:
        """Age in a cell of the link matrix [s]; None if it has none."""
        cell = self.page.locator("table").first.locator("tr").nth(sender).locator("td, th").nth(receiver).inner_text()
        found = re.search(r"([\d.]+) (ms|s)", cell)
        return None if found is None else float(found[1]) * (1e-3 if found[2] == "ms" else 1.0)


def _click(found: "Locator") -> None:
    """Click without waiting for two equal frames, which take seconds when the processor draws them."""
    found.wait_for(state="attached", timeout=20_000)
    found.evaluate("element => { element.scrollIntoView({block: 'center'}); element.click(); }")
