"""The dashboard under a long run: processor time, memory, the page's heap, frames.

python -m benchmarks.soak [--minutes 20] [--robots 20] [--size 1280x720] [--compare CONTROLLER] [--json]

The agents of the run share one process (benchmarks/ensemble.py), so that a machine with few cores has time left for
what is measured: the dashboard's process, with its page open in a headless chromium without a graphics card. Its load
is told in processor time (user and system), which other jobs on the machine disturb little; frames per second are of
the wall clock, and do suffer.
"""

import argparse
import json
import os
import signal
import sys
import time
from typing import Any

import numpy as np
import psutil
import viser  # noqa: TID251  only for the version that its web socket wants to hear
from playwright.sync_api import CDPSession, Page, sync_playwright
from websockets.sync.client import connect
from websockets.typing import Origin, Subprotocol

from benchmarks.controls import size
from network.control import Compare
from runtime.fork_server import ENVIRONMENT
from runtime.precompile import ensure_compiled
from tests.browser.browser_run import BrowserRun
from tests.browser.conftest import FLAGS
from tests.browser.driven import READY, frames

SCENARIO = "ring-16"
WARM_UP_SECONDS = 60.0
"""Caches fill, plots reach their length."""
FULL_SECONDS = 720.0
"""After that the time line is full, and memory should not grow any more."""
SAMPLES = 20
LEAST_SAMPLES = 4
"""For growth after that."""
FRAME_SECONDS = 10.0


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--minutes", type=float, default=20.0, help="of measurement, after a minute of warming up")
    parser.add_argument("--robots", type=int, default=20)
    parser.add_argument("--size", type=size, default="1280x720", help="of the page's window")
    parser.add_argument("--compare", metavar="CONTROLLER", help="with a ghost beside it")
    parser.add_argument("--chromium", default="/usr/bin/chromium")
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    ensure_compiled(print)
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))  # and leave no process behind
    os.environ.update(ENVIRONMENT)
    settings = [f"formation.robots={options.robots}"]
    with (
        BrowserRun(SCENARIO, agents=0, world="benchmarks.ensemble", settings=settings) as run,
        sync_playwright() as playwright,
    ):
        if options.compare:
            run.state(60.0)  # before that nobody is there to be asked
            run.ask(Compare(controller=options.compare))
        browser = playwright.chromium.launch(executable_path=options.chromium, args=FLAGS)
        width, height = options.size
        page = browser.new_page(viewport={"width": width, "height": height})
        figures = _measure(page, run, options.minutes)
        figures |= {"robots": options.robots, "minutes": options.minutes, "ghost": options.compare or ""}
        browser.close()
    if options.json:
        print(json.dumps(figures))
        return
    _print(figures)


def _print(figures: dict[str, Any]) -> None:
    print(f"{figures['robots']} robots, one page, {figures['minutes']:g} minutes:")
    print(
        f"dashboard: {figures['cpu_percent']:.1f} % of a core (processor time), "
        f"while the run went at {figures['pace']:.2f} x real time"
    )
    since = "once the time line was full" if figures["full"] else "while the time line filled"
    for name, text in (("rss", "dashboard's RSS"), ("pss", "dashboard's PSS"), ("heap", "page's heap after GC")):
        first, last, growth = (figures[f"{name}_{part}"] for part in ("first_mb", "last_mb", "growth_mb"))
        slope = figures[f"{name}_slope_mb_per_hour"]
        print(
            f"{text}: {first:.1f} MB, at the end {last:.1f} MB; {since}: medians of the halves {growth:+.2f} MB apart, "
            f"slope {slope:+.1f} MB/h"
        )
    print(
        f"frames: {figures['frames_sent_per_s']:.1f} a second sent, {figures['frames_drawn_per_s']:.1f} drawn by the "
        f"page (software rendering); machine load {figures['load']:.1f} on {os.cpu_count()} cores"
    )


def _measure(page: Page, run: BrowserRun, minutes: float) -> dict[str, Any]:
    opened = time.monotonic()
    page.goto(f"{run.url}/?fixedDpr=1")
    page.wait_for_function(READY, timeout=120_000, polling=200)
    page.wait_for_timeout(1e3 * min(WARM_UP_SECONDS, 20.0 * minutes))
    tools = page.context.new_cdp_session(page)
    dashboard = psutil.Process(run.pid("dashboard"))
    rows, loads = [_row(dashboard, tools)], []
    cpu, drawn, simulated, began = _cpu(dashboard), frames(page), run.state().stamp, time.monotonic()
    for _ in range(SAMPLES):
        page.wait_for_timeout(60e3 * minutes / SAMPLES)
        rows.append(_row(dashboard, tools))
        loads.append(os.getloadavg()[0])
    seconds = time.monotonic() - began
    figures = {"cpu_percent": 100.0 * (_cpu(dashboard) - cpu) / seconds, "load": float(np.mean(loads))}
    figures["pace"] = (run.state().stamp - simulated) / seconds
    figures["frames_drawn_per_s"] = (frames(page) - drawn) / seconds
    figures["frames_sent_per_s"] = _sent(run.url)
    table = np.array(rows)
    full = table[table[:, 0] >= opened + FULL_SECONDS]
    figures["full"] = len(full) >= LEAST_SAMPLES
    settled = full if figures["full"] else table
    for column, name in enumerate(("rss", "pss", "heap"), start=1):
        halves = np.array_split(settled[:, column], 2)
        slope = np.polynomial.Polynomial.fit(settled[:, 0], settled[:, column], 1).convert().coef[1]
        figures[f"{name}_first_mb"], figures[f"{name}_last_mb"] = table[0, column], table[-1, column]
        figures[f"{name}_growth_mb"] = float(np.median(halves[1]) - np.median(halves[0]))
        figures[f"{name}_slope_mb_per_hour"] = 3600.0 * slope
        figures[f"{name}_mb"] = table[:, column].round(2).tolist()
    return figures


def _row(dashboard: psutil.Process, tools: CDPSession) -> tuple[float, float, float, float]:
    """Time [s], RSS and PSS of the dashboard, the page's heap after a collection [MB]."""
    tools.send("HeapProfiler.collectGarbage")
    heap = tools.send("Runtime.getHeapUsage")["usedSize"]
    memory = dashboard.memory_full_info()
    return time.monotonic(), memory.rss / 1e6, memory.pss / 1e6, heap / 1e6


def _cpu(process: psutil.Process) -> float:
    times = process.cpu_times()
    return float(times.user + times.system)


def _sent(address: str) -> float:
    """Updates that the dashboard sends to a client that is quick to read, a second."""
    protocol = [Subprotocol(f"viser-v{viser.__version__}")]
    with connect(address.replace("http", "ws"), origin=Origin(address), subprotocols=protocol, max_size=None) as socket:
        count, began = -1, time.monotonic()
        while (passed := time.monotonic() - began) < FRAME_SECONDS + 2.0:
            socket.recv(timeout=10.0)
            count += passed > 2.0  # first the scene as it is, in many parts
    return (count + 1) / FRAME_SECONDS


if __name__ == "__main__":
    main()
