"""Real time on this machine: missed ticks, memory per agent, and the time from the command to the first tick.

python benchmarks/realtime.py [--robots 8] [--seconds 60] [--json]
"""

import argparse
import contextlib
import json
import os
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import psutil

from network import topics
from network.bus import Sample
from network.codec import decode
from network.messages import State, Status
from network.zenoh_bus import ZenohBus
from runtime.precompile import ensure_compiled
from runtime.run_registry import find

RUN = "benchmark"
WARM_SECONDS = 2.0
"""After the run began, before it is measured [s]: first ticks compute tables and wait for each other."""


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--robots", type=int, default=8)
    parser.add_argument("--seconds", type=float, default=60.0)
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    ensure_compiled(print)
    with tempfile.TemporaryDirectory(prefix="ech") as folder:
        os.environ["ECHELON_RUNS"] = folder
        figures = {"start_s": _start_up(), **real_time(options.robots, options.seconds)}
    if options.json:
        print(json.dumps(figures))
        return
    print(f"up with three robots is running {figures['start_s']:.2f} s after the command")
    print(
        f"real time, {options.robots} agents at 100 Hz for {options.seconds:g} s: "
        f"{figures['missed_share']:.3%} of ticks missed "
        f"(worst agent {figures['missed_share_worst']:.3%}), world overran {figures['overrun_share']:.3%}"
    )
    print(f"memory per agent (PSS): median {figures['pss_mb']:.0f} MB, largest {figures['pss_mb_max']:.0f} MB")


def _start_up() -> float:
    """From `echelon up` (with its page) to simulated time that passes [s]."""
    began = time.perf_counter()
    socket = Path(os.environ["ECHELON_RUNS"]) / RUN / "router.sock"
    with _up("triangle-circle", "--port", "0") as up:
        while not socket.exists():
            time.sleep(0.01)
            if up.poll() is not None:
                raise SystemExit("echelon up ended early")
        with ZenohBus(f"unixsock-stream/{socket}", RUN) as session:
            session.subscribe(topics.state(RUN))
            while True:
                item = session.inbox.get(timeout=30.0)
                if isinstance(item, Sample) and decode(State, item.payload).stamp > 0.0:
                    return time.perf_counter() - began


def real_time(robots: int, seconds: float, *more: str) -> dict[str, float]:
    """Figures of a run in real time; `more` are options of `up`. CPU in shares of a core, memory in MB."""
    shape = ["--set", "formation.shape=polygon", "--set", f"formation.robots={robots}"]
    with _up("circle", "--realtime", "--no-dashboard", *shape, *more) as up:
        while _state().get("status") != "running":
            time.sleep(0.2)
        time.sleep(WARM_SECONDS)
        first, earlier = _state(), _missed(robots)
        print(f"running for {seconds:g} s ...", file=sys.stderr, flush=True)
        memory, before, began = [], _processor(up.pid), time.monotonic()
        for _ in range(3):
            time.sleep(seconds / 3)
            memory.append(_memory(up.pid))
        spent, took = _processor(up.pid), time.monotonic() - began
        last = _state()
        missed = [late - early for late, early in zip(_missed(robots), earlier, strict=True)]
    ticks = (last["stamp"] - first["stamp"]) / 0.01
    pss, private = ([one[at] for sample in memory for one in sample] for at in (0, 1))
    shares = {role: (spent[role] - before[role]) / took for role in before}
    return {
        "ticks": ticks,
        "missed_share": sum(missed) / (ticks * robots),
        "missed_share_worst": max(missed) / ticks,
        "overrun_share": (last["overruns"] - first["overruns"]) / ticks,
        "pss_mb": statistics.median(pss),
        "pss_mb_max": max(pss),
        "private_mb": statistics.median(private),
        "cpu_agent": shares["agent"] / robots,
        "cpu_world": shares["world"],
        "cpu_router": shares["router"],
    }


def _memory(launcher: int) -> list[tuple[float, float]]:
    """PSS and private memory of every process of agents [MB]."""
    found = []
    for process, role in _processes(launcher):
        with contextlib.suppress(psutil.Error):
            if role == "agent":
                memory = process.memory_full_info()
                found.append((memory.pss / 1e6, memory.uss / 1e6))
    return found


def _processor(launcher: int) -> dict[str, float]:
    """Processor time that the processes of each role have used so far [s]."""
    found = dict.fromkeys(("agent", "world", "router"), 0.0)
    for process, role in _processes(launcher):
        with contextlib.suppress(psutil.Error):
            if role in found:
                found[role] += sum(process.cpu_times()[:2])
    return found


def _processes(launcher: int) -> list[tuple[psutil.Process, str]]:
    """Those of the run, with their roles."""
    found = []
    for process in psutil.Process(launcher).children(recursive=True):
        with contextlib.suppress(psutil.Error):
            title, prefix = " ".join(process.cmdline()), f"echelon {RUN}: "
            if title.startswith(prefix):
                found.append((process, title.removeprefix(prefix).split()[0].removesuffix("s")))
    return found


def _missed(robots: int) -> list[int]:
    """Ticks that each agent missed, as it says itself."""
    run = find(RUN)
    counts: dict[int, int] = {}
    with ZenohBus(run.endpoint, RUN) as session:
        session.subscribe(topics.status(RUN, "*"))
        while len(counts) < robots:
            item = session.inbox.get(timeout=5.0)
            if isinstance(item, Sample):
                status = decode(Status, item.payload)
                counts[status.sender] = status.missed
    return [counts[robot] for robot in sorted(counts)]


def _state() -> dict[str, Any]:
    command = [sys.executable, "-m", "cli.main", "status", "--json"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    return json.loads(done.stdout) if done.returncode == 0 else {}


@contextlib.contextmanager
def _up(*words: str) -> Any:
    log = (Path(os.environ["ECHELON_RUNS"]) / "log").open("w")
    up = subprocess.Popen([sys.executable, "-m", "cli.main", "up", "--run", RUN, *words], stdout=log, stderr=log)
    try:
        yield up
    finally:
        up.terminate()
        up.wait(20)
        log.close()


if __name__ == "__main__":
    main()
