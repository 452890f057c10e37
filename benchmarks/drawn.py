"""How often a page shows something new of a formation, by how many robots it has.

python -m benchmarks.drawn [--robots 64,256,1024] [--seconds 10] [--chromium /usr/bin/chromium] [--json FILE]

A world with its agents in its own process (benchmarks/ensemble.py), as few machines bear so many processes: it says how
much simulated time passes in a second. The dashboard and a browser without a graphics card share the machine with it.
"""

import argparse
import json
import os
import sys
import time
from pathlib import Path
from typing import Any

import psutil
from playwright.sync_api import Browser, sync_playwright

from benchmarks.controls import size
from benchmarks.speed import Checkout
from tests.browser.browser_run import BrowserRun
from tests.browser.conftest import FLAGS
from tests.browser.driven import READY

PATIENCE_MS = 600_000
"""Longest wait for a page with all robots [ms]."""
WARM_MS = 5_000
"""Before what is measured [ms]."""
FRAMES = """milliseconds => new Promise(done => {
  const places = () => window.__viserSceneTree.getState()["/bodies"].message.props.batched_positions;
  let frames = 0, moved = 0, before = places();
  const began = performance.now();
  const next = () => {
    const now = places(), passed = performance.now() - began;
    frames += 1;
    moved += now !== before;
    before = now;
    passed < milliseconds ? requestAnimationFrame(next) : done([1000 * frames / passed, 1000 * moved / passed]);
  };
  requestAnimationFrame(next);
})"""
"""Frames a second, and those in which the bodies have other places than in the one before."""
SHOWN = (
    "{robots:4d} robots: {moved_per_s:.1f} of {frames_per_s:.1f} frames/s show new places, {simulated_s_per_s:.2f} "
    "x real time, dashboard {cpu_dashboard:.0%} of a core, {memory_dashboard_mb:.0f} MB"
)


def measure(browser: Browser, robots: int, seconds: float, window: tuple[int, int]) -> dict[str, Any]:
    """Frames that the page draws, those with new places of the robots, and what the dashboard takes, a second."""
    settings = ("formation.shape='polygon'", f"formation.robots={robots}", "formation.spacing=0.1")
    with BrowserRun("circle", robots, agents=0, world="benchmarks.ensemble", settings=settings) as run:
        page = browser.new_page(viewport={"width": window[0], "height": window[1]})
        page.goto(run.url)
        page.wait_for_function(READY, timeout=PATIENCE_MS, polling=100)
        page.wait_for_timeout(WARM_MS)
        dashboard, before = psutil.Process(run.pid("dashboard")), run.state(60.0)
        spent, since = sum(dashboard.cpu_times()[:2]), time.monotonic()
        drawn, moved = page.evaluate(FRAMES, 1e3 * seconds)
        took, after = time.monotonic() - since, run.state(60.0)
        found = {
            "robots": robots,
            "frames_per_s": drawn,
            "moved_per_s": moved,
            "simulated_s_per_s": (after.stamp - before.stamp) / took,
            "cpu_dashboard": (sum(dashboard.cpu_times()[:2]) - spent) / took,
            "memory_dashboard_mb": dashboard.memory_info().rss / 1e6,
        }
        page.close()
        return found


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--robots", default="64,256,1024", metavar="N,N,...")
    parser.add_argument("--seconds", type=float, default=10.0)
    parser.add_argument("--size", type=size, default="1280x720", help="of the page's window")
    parser.add_argument("--chromium", default="/usr/bin/chromium")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the figures here as well")
    options = parser.parse_args()
    rows = []
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=options.chromium, args=FLAGS)
        for robots in map(int, options.robots.split(",")):
            print(f"{robots} robots ...", file=sys.stderr, flush=True)
            rows.append(measure(browser, robots, options.seconds, options.size))
            print(SHOWN.format(**rows[-1]), flush=True)
        browser.close()
    if options.json:
        checkout = Checkout.here()
        facts = {"commit": checkout.commit(), "load": os.getloadavg(), "seconds": options.seconds, "rows": rows}
        options.json.write_text(json.dumps(facts, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
