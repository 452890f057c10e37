"""What tests of live runs share: fixtures, and the processes of a run."""

import contextlib
import ctypes
import json
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import psutil
import pytest

from runtime.precompile import ensure_compiled
from tests.exceptions import needs

WAIT_SECONDS = 90.0
"""Of a machine whose cores are all busy."""


@pytest.fixture(scope="session", autouse=True)
def compiled() -> None:
    needs("unix sockets")
    ensure_compiled(print)


@pytest.fixture
def runs() -> Iterator[Path]:
    """A folder for runs that only this test uses; short, because unix sockets want short paths."""
    folder = Path(tempfile.mkdtemp(prefix="ech"))
    before = os.environ.get("ECHELON_RUNS")
    os.environ["ECHELON_RUNS"] = str(folder)
    yield folder
    if before is None:
        del os.environ["ECHELON_RUNS"]
    else:
        os.environ["ECHELON_RUNS"] = before
    for process in processes(folder):
        with contextlib.suppress(psutil.NoSuchProcess):
            process.kill()
    shutil.rmtree(folder, ignore_errors=True)


def processes(folder: Path) -> list[psutil.Process]:
    """Every live process that was started for runs in this folder."""
    found = []
    for process in psutil.process_iter():
        with contextlib.suppress(psutil.Error):
            if process.pid == os.getpid() or process.status() == psutil.STATUS_ZOMBIE:
                continue
            if process.ppid() == os.getpid() and "multiprocessing" in title(process):
                continue  # the fork server of this test process serves the next tests too
            if process.environ().get("ECHELON_RUNS") == str(folder):
                found.append(process)
    return found


def title(process: psutil.Process) -> str:
    """Of a process of a run, or the command of another one; empty if it has just ended."""
    with contextlib.suppress(psutil.Error):
        return " ".join(process.cmdline()).strip()  # a title leaves the rest of the line empty
    return ""


def echelon(*words: str, check: int | None = 0) -> subprocess.CompletedProcess[str]:
    """Run a command to its end."""
    done = subprocess.run(
        [sys.executable, "-m", "cli.main", *words], capture_output=True, text=True, timeout=120, check=False
    )
    assert check is None or done.returncode == check, done.stderr
    return done


def wait_for(what: Callable[[], Any], seconds: float = WAIT_SECONDS) -> Any:
    """The first true value of `what`; fails after some time."""
    until = time.monotonic() + seconds
    while time.monotonic() < until:
        value = what()
        if value:
            return value
        time.sleep(0.05)
    raise AssertionError(f"still not so after {seconds:g} s: {what}")


def _die_with_parent() -> None:
    """In the child: SIGKILL when the test process dies, however it does (Linux)."""
    ctypes.CDLL(None).prctl(1, signal.SIGKILL)  # PR_SET_PDEATHSIG


class Up:
    """`echelon up` in a process of its own, of three robots on ideal bodies unless the words name a scenario."""

    def __init__(self, folder: Path, *words: str) -> None:
        if not words or words[0].startswith("-"):
            words = ("triangle-circle", *words)
        self.folder = folder
        self.log = (folder / "up.log").open("w+")
        self.process = subprocess.Popen(
            [sys.executable, "-m", "cli.main", "up", "--run", "test", *words],
            stdout=self.log,
            stderr=subprocess.STDOUT,
            preexec_fn=_die_with_parent,  # noqa: PLW1509  it only makes one system call
        )

    def status(self) -> dict[str, Any]:
        """What `echelon status` says; empty if it cannot."""
        done = echelon("status", "--json", check=None)
        return json.loads(done.stdout) if done.returncode == 0 else {}

    def running(self) -> dict[str, Any]:
        """Wait until time passes."""
        state: dict[str, Any] = wait_for(
            lambda: (s := self.status()) and s["status"] == "running" and s["stamp"] > 0.5 and s
        )
        return state

    def pid(self, name: str) -> int:
        """Of the process with this name in its title, such as "agent 2"."""

        def find() -> int | None:
            for process in processes(self.folder):
                if title(process) == f"echelon test: {name}":
                    return int(process.pid)
            return None

        return int(wait_for(find))

    def end(self, number: int = signal.SIGINT) -> int:
        """Send a signal and wait for the end."""
        if self.process.poll() is None:
            self.process.send_signal(number)
        return self.process.wait(20)

    def text(self) -> str:
        """What it has printed."""
        self.log.flush()
        self.log.seek(0)
        return self.log.read()


@pytest.fixture
def up(runs: Path) -> Iterator[Callable[..., Up]]:
    """Starts `echelon up` with further words."""
    started: list[Up] = []

    def start(*words: str) -> Up:
        started.append(Up(runs, *words))
        return started[-1]

    yield start
    for one in started:
        if one.process.poll() is None:
            one.process.kill()
            one.process.wait(10)
        one.log.close()
