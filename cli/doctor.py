"""`echelon doctor`: whether this machine has what a run needs, and what to do where it has not."""

import argparse
import json
import os
import shutil
import socket
import sys
import tomllib
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from importlib.metadata import PackageNotFoundError, requires, version
from pathlib import Path

from rich.console import Console
from rich.table import Table

from agents.kernels.jit_cache import cache_folder, compiled, wanted_place, writable
from cli.up import DEFAULT_PORT, LOOPBACK
from formation.errors import EchelonError
from runtime.run_registry import SOCKET_PATH_LIMIT, folder, live

BROWSERS = ("chromium", "google-chrome", "chromium-browser", "firefox", "xdg-open", "open")
DISTRIBUTION = "echelon-formations"
ADVISED_CORES = 2
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


def run(options: argparse.Namespace) -> int:
    """Print every check; exit code 1 if a run would fail."""
    checks = [*_checks()]
    ready = all(check.ok for check in checks if check.needed)
    if options.json:
        print(json.dumps({"ready": ready, "checks": [asdict(check) for check in checks]}))
        return 0 if ready else 1
    table = Table("check", "found", "", "what to do")
    for check in checks:
        mark = "[green]ok[/]" if check.ok else "[red]missing[/]" if check.needed else "[yellow]note[/]"
        table.add_row(check.name, check.found, mark, "" if check.ok else check.advice)
    console = Console()
    console.print(table)
    console.print("ready: echelon up" if ready else "not ready yet")
    return 0 if ready else 1


def _checks() -> Iterator[Check]:
    python = ".".join(map(str, sys.version_info[:3]))
    yield Check("Python", python, sys.version_info >= ADVISED_PYTHON, True, "install Python 3.11 or newer")
    yield from _packages()
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    yield Check(
        "cores", str(cores), cores >= ADVISED_CORES, False, "real time with many robots wants two; lockstep is fine"
    )
    yield _runs()
    yield _cache()
    with socket.socket() as probe:
        probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            probe.bind((LOOPBACK, DEFAULT_PORT))
            port = Check("port of the page", f"{DEFAULT_PORT} is free", True, False)
        except OSError:
            port = Check("port of the page", f"{DEFAULT_PORT} is taken", False, False, "echelon up --port 0")
    yield port
    browser = next((name for name in BROWSERS if shutil.which(name)), "")
    yield Check("browser", browser or "none", bool(browser), False, "open the page with a browser that knows WebGL2")


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


def _runs() -> Check:
    try:
        path = folder()
        names = ", ".join(run.name for run in live()) or "none"
    except (EchelonError, OSError) as error:
        return Check("folder for runs", str(error), False, True, "set ECHELON_RUNS to a folder of your own")
    room = len(os.fsencode(path)) + 40 <= SOCKET_PATH_LIMIT
    return Check("folder for runs", f"{path} (live: {names})", room, True, "set ECHELON_RUNS to a shorter path")


def _cache() -> Check:
    wanted = wanted_place()
    good = wanted is not None and writable(wanted)
    try:
        text = "compiled" if compiled() else "compiled on first use, about half a minute"
        if not good:
            text = f"{text}; kept in {cache_folder()}, as {wanted} cannot be written"
    except EchelonError as error:
        text = str(error)
    return Check("solver", text, good, True, "set ECHELON_CACHE to a folder that can be written")
