"""`echelon doctor`: whether this machine has what a run needs, and what to do where it has not.

It prints its table whatever is missing: a check imports what it needs, and one that fails is a line of the table.
"""

import argparse
import json
import os
import resource
import shutil
import socket
import sys
import time
import tomllib
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass
from functools import partial
from importlib.metadata import PackageNotFoundError, requires, version
from pathlib import Path

BROWSERS = ("chromium", "google-chrome", "chromium-browser", "firefox", "xdg-open", "open")
DISTRIBUTION = "echelon-formations"
ADVISED_NAME = 25
"""Letters of a run's name that have room in its folder's path."""
ADVISED_CORES = 2
ADVISED_FILES = 256
"""Open files: a run of 64 agents with a process each, and a page, wants so many."""
ADVISED_AGENTS = 3
ADVISED_TRIP, ADVISED_OFFSET = 0.02, 1.0
"""Longest round trip, and largest difference of two hosts' clocks [s]."""
TRIPS, TRIP_SECONDS = 20, 1.0
"""Round trips that are measured, and how long each is waited for [s]."""
ADVISED_PYTHON = (3, 11)


@dataclass(frozen=True, slots=True)
class Check:
    """The result of one check."""

    name: str
    found: str
    ok: bool
    needed: bool
    """Whether a run fails without it."""
    advice: str = ""


def arguments(parser: argparse.ArgumentParser) -> None:
    """What the command accepts."""
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    parser.add_argument("--connect", metavar="HOST[:PORT]", help="measure the way to a run on another host as well")
    parser.add_argument("--run", help=argparse.SUPPRESS)
    parser.add_argument("--code", help="for --connect the first time, as `echelon invite` printed it there")
    parser.add_argument("--insecure", action="store_true", help="for --connect tcp/HOST:PORT, which strangers can use")


def run(options: argparse.Namespace) -> int:
    """Print every check; exit code 1 if a run would fail."""
    groups: list[Callable[[], Iterator[Check]]] = [*_GROUPS, *([partial(_way, options)] if options.connect else [])]
    checks = [check for group in groups for check in _guarded(group)]
    ready = all(check.ok for check in checks if check.needed)
    if options.json:
        print(json.dumps({"ready": ready, "checks": [asdict(check) for check in checks]}))
        return 0 if ready else 1
    try:
        _print(checks)
    except ImportError:
        for check in checks:
            print(f"{check.name}: {check.found}, {_mark(check)}{'' if check.ok else f' ({check.advice})'}")
    print("ready: echelon up" if ready else "not ready yet")
    return 0 if ready else 1


def _guarded(group: Callable[[], Iterator[Check]]) -> list[Check]:
    """The checks of a group; what prevents one of them is its result."""
    found = []
    try:
        for check in group():
            found.append(check)
    except Exception as error:
        reason = f"{type(error).__name__}: {error}".splitlines()[0]
        name = getattr(group, "__name__", "way to the run").strip("_")
        found.append(Check(name, reason, False, True, "mend what is missing above first"))
    return found


def _mark(check: Check) -> str:
    return "ok" if check.ok else "missing" if check.needed else "note"


def _print(checks: list[Check]) -> None:
    from rich.console import Console  # noqa: PLC0415  may be missing
    from rich.table import Table  # noqa: PLC0415

    colours = {"ok": "green", "missing": "red", "note": "yellow"}
    table = Table("check", "found", "", "what to do")
    for check in checks:
        mark = _mark(check)
        table.add_row(check.name, check.found, f"[{colours[mark]}]{mark}[/]", "" if check.ok else check.advice)
    Console().print(table)


def _python() -> Iterator[Check]:
    found = ".".join(map(str, sys.version_info[:3]))
    yield Check("Python", found, sys.version_info >= ADVISED_PYTHON, True, "install Python 3.11 or newer")


def _machine() -> Iterator[Check]:
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    yield Check(
        "cores", str(cores), cores >= ADVISED_CORES, False, "real time with many robots wants two; lockstep is fine"
    )
    limit = resource.getrlimit(resource.RLIMIT_NOFILE)[1]
    enough = limit == resource.RLIM_INFINITY or limit >= ADVISED_FILES
    yield Check("open files", "any" if limit < 0 else str(limit), enough, False, f"ulimit -n {ADVISED_FILES}, or more")
    browser = next((name for name in BROWSERS if shutil.which(name)), "")
    yield Check("browser", browser or "none", bool(browser), False, "open the page with a browser that knows WebGL2")


def _page() -> Iterator[Check]:
    from cli.light_options import DEFAULT_PORT, LOOPBACK  # noqa: PLC0415

    with socket.socket() as probe:
        probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            probe.bind((LOOPBACK, DEFAULT_PORT))
            yield Check("port of the page", f"{DEFAULT_PORT} is free", True, False)
        except OSError:
            yield Check("port of the page", f"{DEFAULT_PORT} is taken", False, False, "echelon up --port 0")


def _packages() -> Iterator[Check]:
    try:
        wanted = [line.split(";")[0].strip() for line in requires(DISTRIBUTION) or () if "extra ==" not in line]
    except PackageNotFoundError:
        project = Path(__file__).parent.parent / "pyproject.toml"
        wanted = tomllib.loads(project.read_text())["project"]["dependencies"] if project.exists() else []
    for wish in wanted:
        name, _, pinned = wish.partition("==")
        try:
            found = version(name)
        except PackageNotFoundError:
            found = "not installed"
        yield Check(name, found, found == pinned, True, f"./echelon --help sets it up, or: pip install {wish}")


def _runs() -> Iterator[Check]:
    from formation.errors import EchelonError  # noqa: PLC0415
    from runtime.run_registry import check_path, folder, live  # noqa: PLC0415

    try:
        path = folder()
        check_path(path / ("x" * ADVISED_NAME))
        names = ", ".join(run.name for run in live()) or "none"
    except (EchelonError, OSError) as error:
        yield Check("folder for runs", str(error), False, True, "set ECHELON_RUNS to a folder of your own")
        return
    yield Check("folder for runs", f"{path} (live: {names})", True, True)


def _solver() -> Iterator[Check]:
    from agents.kernels.jit_cache import cache_folder, compiled, wanted_place, writable  # noqa: PLC0415
    from formation.errors import EchelonError  # noqa: PLC0415

    wanted = wanted_place()
    good = wanted is not None and writable(wanted)
    try:
        text = "compiled" if compiled() else "compiled on first use, about half a minute"
        if not good:
            text = f"{text}; kept in {cache_folder()}, as {wanted or 'a home folder'} cannot be written"
    except EchelonError as error:
        text = str(error)
    yield Check("solver", text, good, True, "set ECHELON_CACHE to a folder that can be written")


def _agents() -> Iterator[Check]:
    from agents.kernels.jit_cache import compiled  # noqa: PLC0415
    from formation.errors import EchelonError  # noqa: PLC0415

    name = "agents in real time"
    try:
        if not compiled():
            yield Check(name, "measured once the solver is compiled", True, False)
            return
    except EchelonError:
        return  # the check before says why
    from runtime.machine.capacity import measured  # noqa: PLC0415

    found = measured()
    text = f"about {found.alone} at 100 Hz with a process each, {found.together} that share {found.cores}"
    yield Check(name, text, found.alone >= ADVISED_AGENTS, False, "with more of them up has several share a process")


def _way(options: argparse.Namespace) -> Iterator[Check]:
    """The way to a run on another host, and its clock."""
    from cli.options import session  # noqa: PLC0415
    from network import topics  # noqa: PLC0415

    with session(options) as live:
        stamps = live.stamps(topics.state(live.run))
        trips = []
        for _ in range(TRIPS):
            begun = time.monotonic()
            if live.setup(timeout=TRIP_SECONDS) is not None:
                trips.append(time.monotonic() - begun)
        if not trips:
            yield Check("round trip", "no answer", False, True, "is its world alive? echelon status there")
            return
        trip = min(trips)
        yield Check("round trip", f"{trip * 1e3:.1f} ms", trip < ADVISED_TRIP, False, "lockstep takes it for each tick")
        passed, arrived = stamps.get(timeout=TRIP_SECONDS)
        while not stamps.empty():  # what came fastest says most
            passed, arrived = max((passed, arrived), stamps.get(), key=lambda stamp: stamp[0] - stamp[1])
        ahead = passed - arrived + trip / 2.0
        text = f"{abs(ahead) * 1e3:.1f} ms {'ahead' if ahead > 0.0 else 'behind'}, within {trip * 5e2:.1f} ms"
        yield Check(
            "its clock",
            text,
            abs(ahead) < ADVISED_OFFSET,
            False,
            "no run depends on it, but times of logs differ",
        )


_GROUPS = (_python, _packages, _machine, _runs, _solver, _agents, _page)
