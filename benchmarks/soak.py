"""The dashboard under a long run: processor time, memory, the page's heap, frames.

python -m benchmarks.soak [--minutes 20] [--robots 20] [--size 1280x720] [--compare CONTROLLER] [--json]

The minds of the run share one process (benchmarks/ensemble.py), so that a machine with few cores has time left for what
is measured: the dashboard's process, with its page open in a headless chromium without a graphics card. Its load is
told in processor time (user and system), which other jobs on the machine disturb little; frames per second are of the
wall clock, and do suffer.
"""

import argparse
import json
import os
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any, Self

import numpy as np
import psutil
import viser  # noqa: TID251  only for the version that its web socket wants to hear
from playwright.sync_api import CDPSession, Page, sync_playwright
from websockets.sync.client import connect
from websockets.typing import Origin, Subprotocol

from fleet.compiling import ensure_compiled
from fleet.supervisor import ENVIRONMENT
from network import keys
from network.codec import decode
from network.control import Compare
from network.messages import State
from network.session import Sample, Session
from tests.browser.conftest import FLAGS
from tests.browser.driven import READY

RUN = "soak"
SCENARIO = "ring-16"
WARM_UP_SECONDS = 60.0
"""Caches fill, plots reach their length."""
SAMPLES = 20
FRAME_SECONDS = 10.0


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--minutes", type=float, default=20.0, help="of measurement, after a minute of warming up")
    parser.add_argument("--robots", type=int, default=20)
    parser.add_argument("--size", default="1280x720", help="of the page's window")
    parser.add_argument("--compare", metavar="CONTROLLER", help="with a ghost beside it")
    parser.add_argument("--chromium", default="/usr/bin/chromium")
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    ensure_compiled(print)
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))  # and leave no process behind
    width, height = (int(number) for number in options.size.split("x"))
    with (
        tempfile.TemporaryDirectory(prefix="ech") as folder,
        sync_playwright() as playwright,
        _Run(options.robots, Path(folder)) as run,
    ):
        if options.compare:
            with Session(run.endpoint, RUN) as session:
                session.ask(Compare(controller=options.compare))
        browser = playwright.chromium.launch(executable_path=options.chromium, args=FLAGS)
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
    for name, text in (("rss", "dashboard's RSS"), ("pss", "dashboard's PSS"), ("heap", "page's heap after GC")):
        first, last, growth = (figures[f"{name}_{part}"] for part in ("first_mb", "last_mb", "growth_mb"))
        slope = figures[f"{name}_slope_mb_per_hour"]
        print(
            f"{text}: {first:.1f} MB, at the end {last:.1f} MB; medians of the halves {growth:+.2f} MB apart; "
            f"slope {slope:+.1f} MB/h"
        )
    print(
        f"frames: {figures['frames_sent_per_s']:.1f} a second sent, {figures['frames_drawn_per_s']:.1f} drawn by the "
        f"page (software rendering); machine load {figures['load']:.1f} on {os.cpu_count()} cores"
    )


class _Run:
    """Router, world with all minds, ghost and dashboard; use as a context manager."""

    def __init__(self, robots: int, folder: Path) -> None:
        self.endpoint = f"unixsock-stream/{folder / 'router'}"
        self._started: list[subprocess.Popen[str]] = []
        os.environ.update(ENVIRONMENT)
        self._start("network", "--listen", self.endpoint)
        while not (folder / "router").exists():
            time.sleep(0.05)
        common = ("--run", RUN, "--connect", self.endpoint)
        self._start("benchmarks.ensemble", *common, "--scenario", SCENARIO, "--set", f"formation.robots={robots}")
        self._start("fleet.ghost", *common)
        dashboard = self._start("dashboard", *common, "--port", "0")
        assert dashboard.stdout is not None
        self.address = dashboard.stdout.readline().split()[-1]
        self.dashboard = psutil.Process(dashboard.pid)

    def _start(self, module: str, *words: str) -> "subprocess.Popen[str]":
        command = [sys.executable, "-m", module, *words]
        self._started.append(subprocess.Popen(command, stdout=subprocess.PIPE, text=True))
        return self._started[-1]

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        for process in reversed(self._started):  # the router last, so that the others can say goodbye
            process.terminate()
            process.wait(20)


def _measure(page: Page, run: _Run, minutes: float) -> dict[str, Any]:
    page.goto(f"{run.address}/?fixedDpr=1")
    page.wait_for_function(READY, timeout=120_000, polling=200)
    page.wait_for_timeout(1e3 * min(WARM_UP_SECONDS, 20.0 * minutes))
    tools = page.context.new_cdp_session(page)
    rows, loads = [_row(run.dashboard, tools)], []
    cpu, drawn, simulated, began = _cpu(run.dashboard), _drawn(page), _stamp(run.endpoint), time.monotonic()
    for _ in range(SAMPLES):
        page.wait_for_timeout(60e3 * minutes / SAMPLES)
        rows.append(_row(run.dashboard, tools))
        loads.append(os.getloadavg()[0])
    seconds = time.monotonic() - began
    figures = {"cpu_percent": 100.0 * (_cpu(run.dashboard) - cpu) / seconds, "load": float(np.mean(loads))}
    figures["pace"] = (_stamp(run.endpoint) - simulated) / seconds
    figures["frames_drawn_per_s"] = (_drawn(page) - drawn) / seconds
    figures["frames_sent_per_s"] = _sent(run.address)
    table = np.array(rows)
    for column, name in enumerate(("rss", "pss", "heap"), start=1):
        halves = np.array_split(table[:, column], 2)
        slope = np.polynomial.Polynomial.fit(table[:, 0], table[:, column], 1).convert().coef[1]
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


def _stamp(endpoint: str) -> float:
    """Simulated time of the run [s]."""
    with Session(endpoint, RUN) as session:
        session.subscribe(keys.state(RUN))
        while True:
            item = session.inbox.get(timeout=30.0)
            if isinstance(item, Sample):
                return decode(State, item.payload).stamp


def _cpu(process: psutil.Process) -> float:
    times = process.cpu_times()
    return float(times.user + times.system)


def _drawn(page: Page) -> int:
    return int(page.evaluate("window.__viserTestpoints.rendererInfo.render.frame"))


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
