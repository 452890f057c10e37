"""How soon the page of a record shows its first picture, and how soon a drag on its time line is answered.

.venv/bin/python -m benchmarks.replay [FILE] [--drags 20] [--chromium /usr/bin/chromium]

Without a file, ten minutes of sixteen robots are simulated first. Both are times of the wall clock. The first picture
is told in parts: from the command to the address, which is the start of a process, and from there to robots on the page
of a browser that is open already. A drag is answered when the page has the robots of the other moment.
"""

import argparse
import subprocess
import sys
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory
from time import monotonic

from playwright.sync_api import sync_playwright

from tests.browser.browser_run import ROOT
from tests.browser.conftest import FLAGS
from tests.browser.driven import Driven

SHOWN = """() => window.__viserSceneTree && (window.__viserSceneTree.getState()["/bodies"] || {message: null}).message
  && window.__viserTestpoints.rendererInfo.render.frame > 0"""
DRAG = """async share => {
  const track = document.querySelector(".e-track"), box = track.getBoundingClientRect();
  const places = () => window.__viserSceneTree.getState()["/bodies"].message.props.batched_positions;
  const before = places(), started = performance.now();
  for (const kind of ["pointerdown", "pointerup"])
    track.dispatchEvent(new PointerEvent(kind, {clientX: box.left + share * box.width, clientY: box.top + 50,
      bubbles: true, pointerId: 1}));
  while (places() === before && performance.now() - started < 5000) await new Promise(next => setTimeout(next, 2));
  return performance.now() - started;
}"""


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("file", type=Path, nargs="?", help="a record")
    parser.add_argument("--drags", type=int, default=20)
    parser.add_argument("--chromium", default="/usr/bin/chromium")
    options = parser.parse_args()
    with TemporaryDirectory(prefix="echelon-") as folder:
        file = options.file or Path(folder, "ring.mcap")
        if options.file is None:
            command = ["run", "ring-16", "--engine", "inprocess", "--duration", "600", f"--record={file}"]
            subprocess.run([sys.executable, "-m", "cli.main", *command], cwd=ROOT, check=True, capture_output=True)
        measure(file, options.drags, options.chromium)


def measure(file: Path, drags: int, chromium: str) -> None:
    """Serve the record, and look at it."""
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=chromium, args=FLAGS)
        browser.new_page().goto("about:blank")
        started = monotonic()
        command = [sys.executable, "-m", "cli.main", "replay", str(file), "--port", "0"]
        served = subprocess.Popen(command, cwd=ROOT, text=True, stdout=subprocess.PIPE)
        try:
            assert served.stdout is not None
            url = served.stdout.readline().split()[-1]
            address = monotonic() - started
            page = browser.new_page(viewport={"width": 1280, "height": 720})
            page.goto(f"{url}/?fixedDpr=1")
            page.wait_for_function(SHOWN, polling=20, timeout=60_000)
            first = monotonic() - started
            page.close()
            print(
                f"{file.stat().st_size / 1e6:.1f} MB; address after {address:.2f} s, first picture after {first:.2f} s"
            )
            driven = Driven(browser, url, width=1280, height=720)
            driven.page.wait_for_timeout(12_000)
            times = [driven.page.evaluate(DRAG, (7 * i % drags + 0.5) / drags) for i in range(drags)]
            print(
                f"a drag is answered within {median(times):.0f} ms (median), {max(times):.0f} ms (largest of {drags})"
            )
        finally:
            served.terminate()
            served.wait(10.0)
        browser.close()


if __name__ == "__main__":
    main()
