"""How long a press on the page takes until the page shows what the world made of it.

.venv/bin/python -m benchmarks.controls [--times 5] [--size 1280x720] [--chromium /usr/bin/chromium]

Starts a run of three robots and a browser; needs the test packages. The page takes in what the dashboard says when it
draws its next frame: without a graphics card, and in a large window, most of the time is this waiting, which is told
as well.
"""

import argparse
import re
from statistics import median
from time import monotonic

from playwright.sync_api import sync_playwright

from tests.browser.browser_run import BrowserRun
from tests.browser.conftest import FLAGS
from tests.browser.driven import Driven

GOAL_MS = 200.0
MEASURE = """async ([press, shown]) => {
  const started = performance.now();
  Function(press)();
  const seen = Function("return " + shown);
  while (!seen()) {
    if (performance.now() - started > 20000) return NaN;
    await new Promise(next => setTimeout(next, 1));
  }
  return performance.now() - started;
}"""
BUTTON = "[...document.querySelectorAll('button')].find(b => b.textContent.trim() === '{}')"
BOX = "document.getElementById([...document.querySelectorAll('label')].find(l => l.textContent === '{}').htmlFor)"
CELL = "document.querySelector('[aria-label=\"{}\"]').dispatchEvent(new PointerEvent('pointerdown', {{bubbles: true}}))"
SAYS = "document.body.innerText.includes('{}')"


def controls() -> list[tuple[str, str, str]]:
    """Name, what is done, and what shows that it was; each undoes the one before."""
    press, box = BUTTON.format, BOX.format
    return [
        ("Pause", f"{press('Pause')}.click()", SAYS.format("PAUSED")),
        ("Start", f"{press('Start')}.click()", SAYS.format("RUNNING")),
        ("cell of the link matrix", CELL.format("link 2"), f"{box('Target')}.value === '2 → 3'"),
        ("Cut", f"{box('Cut')}.click()", SAYS.format("2→3 cut")),
        ("Clear this target", f"{press('Clear this target')}.click()", SAYS.format("No faults")),
        ("corner of the link matrix", CELL.format("all 0"), f"{box('Target')}.value === 'All links'"),
        ("Reset", f"{press('Reset')}.click()", SAYS.format("t = 0.")),
    ]


def size(text: str) -> tuple[int, int]:
    """Width and height of a window, from "1280x720" [px]."""
    found = re.fullmatch(r"(\d{2,4})x(\d{2,4})", text)
    if found is None:
        raise argparse.ArgumentTypeError(f"expected WIDTHxHEIGHT; got {text!r}")
    return int(found[1]), int(found[2])


def main() -> None:
    """Press each control some times; print the medians."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--times", type=int, default=5)
    parser.add_argument("--size", type=size, default="1280x720", help="of the page's window")
    parser.add_argument("--chromium", default="/usr/bin/chromium")
    options = parser.parse_args()
    found: dict[str, list[float]] = {}
    with BrowserRun("triangle-circle", robots=3) as run, sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=options.chromium, args=FLAGS)
        width, height = options.size
        driven = Driven(browser, run.url, width=width, height=height)
        driven.wait_text(r"t = [3-9]")
        frames, began = driven.frames, monotonic()
        for _ in range(options.times):
            for name, press, shown in controls():
                found.setdefault(name, []).append(float(driven.page.evaluate(MEASURE, [press, shown])))
                driven.page.wait_for_timeout(120)
        pause = 1e3 * (monotonic() - began) / max(1, driven.frames - frames)
        browser.close()
    print(f"the page draws a frame each {pause:.0f} ms")
    for name, times in found.items():
        print(f"{name:26} median {median(times):5.0f} ms, slowest {max(times):5.0f} ms (goal {GOAL_MS:.0f} ms)")


if __name__ == "__main__":
    main()
