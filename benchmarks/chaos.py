"""Seeded random faults of processes in a live run: whole again within 5 s, and nothing left behind.

python -m benchmarks.chaos [--scenario triangle-circle] [--faults 200] [--seed 1] [--realtime] [--json]

Kills, SIGTERMs and freezes of agents, world, router and ghost, alone and in pairs, one after the other. After each, the
run is whole once every agent takes part and simulated time goes on; the time to that counts from the fault, of a freeze
from its end. The limit on deaths in a row, by which `up` gives up, is lifted. Then lockstep episodes in which processes
are frozen only are compared with the engine in one process, and every process and folder of the runs must be gone.
Freezes are shorter than the lease (network/zenoh_bus.py); an agent that is lost all the same makes another episode: the
figures name it, with the events.
"""

import argparse
import json
import os
import platform
import random
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any

import psutil

from formation.scenario.files import load
from formation.scenario.scenario import Scenario
from network.run_folder import VARIABLE
from runtime import inprocess, supervisor
from runtime.launcher import LiveRun
from runtime.precompile import ensure_compiled

WHOLE_SECONDS = 5.0
"""What is asked for."""
PATIENCE_SECONDS = 60.0
"""After this long a run counts as one that waits for ever."""
FREEZE_SECONDS = 7.0
KINDS = {"kill": signal.SIGKILL, "term": signal.SIGTERM, "freeze": signal.SIGSTOP}
GOES_ON = 0.1
"""Simulated time that must pass for a run to count as going on [s]."""


class Chaos:
    """Faults on one run."""

    def __init__(self, live: LiveRun, scenario: Scenario, seed: int) -> None:
        self._live, self._draws = live, random.Random(seed)
        self._names = ["router", "world", "ghost", *(f"agent {i}" for i in range(1, scenario.size + 1))]
        self._robots = list(range(1, scenario.size + 1))

    def settle(self, seconds: float) -> float | None:
        """Wait until the run is whole; how long that took [s], or None if it is not."""
        began, first = time.monotonic(), None
        seen = -1
        while time.monotonic() - began < seconds:
            self._watch()
            state = self._live.state
            if state is None or state.seq == seen:
                continue
            seen = state.seq
            if state.live != self._robots or state.status != "running":
                first = None
            elif first is None:
                first = state.stamp
            elif state.stamp > first + GOES_ON:
                return time.monotonic() - began
        return None

    def strike(self) -> dict[str, Any]:
        """One fault, of one process or of two at once, and what came of it."""
        draws = self._draws
        kind = draws.choice(list(KINDS))
        names = draws.sample(self._names, draws.choice((1, 1, 2)))
        self._wait(draws.uniform(0.0, 1.0))
        hit = [pid for name in names if (pid := self._pid(name))]
        for pid in hit:
            with suppress(ProcessLookupError):
                os.kill(pid, KINDS[kind])
        if kind == "freeze":
            self._wait(FREEZE_SECONDS)
            for pid in hit:
                with suppress(ProcessLookupError):
                    os.kill(pid, signal.SIGCONT)
        else:
            self._wait(0.3)  # until then the last state before the fault would pass for one after it
        took = self.settle(PATIENCE_SECONDS)
        waited = 0.0 if kind == "freeze" else 0.3
        return {"kind": kind, "names": names, "whole_s": None if took is None else round(took + waited, 3)}

    def _wait(self, seconds: float) -> None:
        until = time.monotonic() + seconds
        while time.monotonic() < until:
            self._watch()

    def _watch(self) -> None:
        if not self._live.watch():
            raise SystemExit("the run has ended by itself")

    def _pid(self, name: str) -> int | None:
        title = f"echelon {self._live.name}: {name}"
        return next((process.pid for process in _processes() if _title(process) == title), None)


def _title(process: psutil.Process) -> str:
    with suppress(psutil.Error):
        return "".join(process.cmdline()[:1])
    return ""


def _processes() -> list[psutil.Process]:
    """Every live process below this one."""
    return [one for one in psutil.Process().children(recursive=True) if one.status() != psutil.STATUS_ZOMBIE]


def strikes(
    scenario: Scenario, count: int, seed: int, *, realtime: bool, tell: Callable[[str], None] = lambda _: None
) -> list[dict[str, Any]]:
    """So many faults in one run, and what came of each."""
    supervisor.DEATH_WINDOW = 0.0
    with LiveRun(f"chaos-{os.getpid()}", scenario, tell=tell, endless=True, ghost=True, realtime=realtime) as live:
        chaos = Chaos(live, scenario, seed)
        if chaos.settle(PATIENCE_SECONDS) is None:
            raise SystemExit("the run did not begin")
        return [chaos.strike() for _ in range(count)]


def frozen(scenario: Scenario, seed: int) -> dict[str, Any]:
    """A lockstep episode during which processes are frozen, and nothing else: who, for how long, and its hash."""
    draws = random.Random(seed)
    with LiveRun(f"chaos-{os.getpid()}", scenario, tell=lambda _: None, speed=1.0) as live:
        chaos = Chaos(live, scenario, seed)
        chaos.settle(PATIENCE_SECONDS)
        names = draws.sample(["router", "world", *(f"agent {i}" for i in range(1, scenario.size + 1))], 2)
        pids = [pid for name in names if (pid := chaos._pid(name))]
        for pid in pids:
            os.kill(pid, signal.SIGSTOP)
        began = time.monotonic()
        chaos._wait(FREEZE_SECONDS)
        for pid in pids:
            os.kill(pid, signal.SIGCONT)
        found = {"names": names, "seconds": round(time.monotonic() - began, 1), "hash": "not finished"}
        until = time.monotonic() + PATIENCE_SECONDS
        while live.watch() and time.monotonic() < until:
            if live.state is not None and live.state.status == "finished":
                summary = live.summary(0.0)
                lost = [event["text"] for event in summary["events"] if event["severity"] != "info"]
                return {**found, "hash": summary["trajectory_sha256"], "events": lost}
    return found


def main() -> None:
    """Run and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scenario", default="triangle-circle", help="a shipped one, or a file")
    parser.add_argument("--faults", type=int, default=200)
    parser.add_argument("--freezes", type=int, default=3, help="lockstep episodes that are only frozen")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--realtime", action="store_true")
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    ensure_compiled(print)
    began = time.monotonic()
    with tempfile.TemporaryDirectory(prefix="ech") as folder:
        os.environ[VARIABLE] = folder
        scenario = load(options.scenario)
        tell = (lambda _: None) if options.json else print
        found = strikes(scenario, options.faults, options.seed, realtime=options.realtime, tell=tell)
        short = load(options.scenario, ["duration=4"])
        freezes = [frozen(short, options.seed + i) for i in range(options.freezes)]
        expected = str(inprocess.simulate(short)["trajectory_sha256"])
        left = [_title(process) for process in _processes() if "echelon " in _title(process)]
        folders = sorted(str(path) for path in Path(folder).iterdir())
    late = [one for one in found if one["whole_s"] is None or one["whole_s"] > WHOLE_SECONDS]
    times = sorted(one["whole_s"] for one in found if one["whole_s"] is not None)
    commit = subprocess.run(["git", "rev-parse", "HEAD"], capture_output=True, text=True, check=False).stdout.strip()
    figures = {
        "scenario": options.scenario,
        "faults": len(found),
        "seed": options.seed,
        "mode": "realtime" if options.realtime else "lockstep",
        "whole_s": {"median": times[len(times) // 2], "max": times[-1]} if times else None,
        "late": late,
        "never_whole": sum(one["whole_s"] is None for one in found),
        "orphans": left,
        "leftovers": folders,
        "frozen_episodes": options.freezes,
        "frozen_hash_unchanged": all(one["hash"] == expected for one in freezes),
        "frozen": [one for one in freezes if one["hash"] != expected],
        "seconds": round(time.monotonic() - began, 1),
        "load": os.getloadavg()[0],
        "commit": commit,
        "machine": f"{platform.machine()}, {os.cpu_count()} cores",
    }
    print(json.dumps(figures, indent=None if options.json else 2))
    sys.exit(bool(late or left or folders or not figures["frozen_hash_unchanged"]))


if __name__ == "__main__":
    main()
