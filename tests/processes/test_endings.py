"""However a command ends, and whatever its streams are: one line or silence, and nothing is left."""

import json
import os
import resource
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import IO, Any

import psutil
import pytest

from tests.processes.live import processes, title, wait_for

pytestmark = pytest.mark.processes
CLI = [sys.executable, "-m", "cli.main"]
RUN = ["run", "triangle-circle", "--duration", "0.1", "--json"]
UP = ["up", "triangle-circle", "--no-dashboard"]


@pytest.fixture
def temporary(monkeypatch: Any) -> Iterator[Path]:
    """The folder for temporary files of commands that a test starts; short, because unix sockets want short paths."""
    with tempfile.TemporaryDirectory(prefix="ech") as folder:
        monkeypatch.setenv("TMPDIR", folder)
        yield Path(folder)


def command(words: list[str], **options: Any) -> subprocess.CompletedProcess[str]:
    return subprocess.run([*CLI, *words], text=True, timeout=100, check=False, **options)


def lines(text: str) -> list[str]:
    assert "Traceback" not in text
    return text.splitlines()


@contextmanager
def full_device() -> Iterator[IO[str]]:
    with open("/dev/full", "w") as file:
        yield file


@pytest.mark.parametrize("words", [RUN, ["scenarios"], ["doctor"]], ids=["run", "scenarios", "doctor"])
def test_a_reader_that_has_enough_ends_a_command_in_silence(runs: Path, words: list[str]) -> None:
    reading, writing = os.pipe()
    os.close(reading)
    done = command(words, stdout=writing, stderr=subprocess.PIPE)
    os.close(writing)
    assert done.stderr == ""
    assert not list(runs.iterdir())


@pytest.mark.parametrize("words", [RUN, ["scenarios"]], ids=["run", "scenarios"])
def test_a_full_device_is_one_line(runs: Path, words: list[str]) -> None:
    with full_device() as full:
        done = command(words, stdout=full, stderr=subprocess.PIPE)
    assert done.returncode == 2
    (line,) = lines(done.stderr)
    assert line.startswith(f"echelon {words[0]}: ")
    assert "No space left" in line
    assert not list(runs.iterdir())


@pytest.mark.parametrize("words", [RUN, ["study", "--list", "--json"]], ids=["run", "study"])
@pytest.mark.parametrize("stream", ["closed", "full"])
def test_results_come_without_a_stderr(runs: Path, words: list[str], stream: str) -> None:
    with full_device() as full:
        closed = {"preexec_fn": lambda: os.close(2)} if stream == "closed" else {"stderr": full}
        done = command(words, stdout=subprocess.PIPE, **closed)
    assert done.returncode == 0
    assert json.loads(done.stdout)


def test_without_any_stream_a_run_comes_to_its_end(runs: Path) -> None:
    def close() -> None:
        os.closerange(0, 3)

    assert command(RUN, preexec_fn=close).returncode == 0
    assert not list(runs.iterdir())


def test_a_full_disk_is_one_line(runs: Path) -> None:
    """No file can grow, as on a full disk: the folder for runs is there, and nothing can be written into it."""

    def fill() -> None:
        resource.setrlimit(resource.RLIMIT_FSIZE, (0, 0))

    done = command(RUN, preexec_fn=fill, capture_output=True)
    assert done.returncode == 2
    assert len(lines(done.stderr)) == 1
    assert done.stdout == ""
    assert not list(runs.iterdir())


def started(words: list[str]) -> subprocess.Popen[str]:
    """A command that leads a group of processes, as in a terminal."""
    return subprocess.Popen(
        [*CLI, *words], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True
    )


def end(process: subprocess.Popen[str], number: signal.Signals) -> str:
    """Send the signal as a terminal does, to the whole group, but SIGKILL as people do; what was printed after it."""
    (os.kill if number == signal.SIGKILL else os.killpg)(process.pid, number)
    out, err = process.communicate(timeout=30)
    return out + err


def fork_servers(runs: Path) -> list[psutil.Process]:
    return [process for process in processes(runs) if "multiprocessing.forkserver" in title(process)]


ENDINGS = [signal.SIGINT, signal.SIGHUP, signal.SIGQUIT, signal.SIGKILL]


@pytest.mark.parametrize("number", ENDINGS)
def test_an_end_while_it_still_imports_is_silent(runs: Path, temporary: Path, number: signal.Signals) -> None:
    process = started(UP)
    wait_for(lambda: fork_servers(runs))  # one has just begun, and removes its folder from here on
    assert end(process, number) == ""
    wait_for(lambda: not processes(runs), 20.0)
    assert not list(temporary.iterdir())
    assert not list(runs.iterdir())


@pytest.mark.parametrize("number", ENDINGS)
def test_an_end_of_a_live_run_leaves_nothing(runs: Path, temporary: Path, number: signal.Signals) -> None:
    process = started(UP)
    assert process.stderr is not None
    assert "running triangle-circle" in process.stderr.readline()
    text = end(process, number)
    lines(text)
    wait_for(lambda: not processes(runs), 20.0)
    assert not list(temporary.iterdir())
    assert not list(runs.iterdir())


def test_an_interrupt_at_any_moment_of_its_start_is_no_traceback(runs: Path, temporary: Path) -> None:
    process = started(UP)
    began = time.monotonic()
    assert process.stderr is not None
    process.stderr.readline()
    whole = time.monotonic() - began
    end(process, signal.SIGINT)
    for share in (0.6, 0.8, 0.9):
        process = started(UP)
        time.sleep(share * whole)
        lines(end(process, signal.SIGINT))
    wait_for(lambda: not processes(runs), 20.0)
    assert not list(temporary.iterdir())
    assert not list(runs.iterdir())
