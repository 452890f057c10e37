"""Commands that are killed in the middle, and clusters of real processes: for tests of what resumes."""

import contextlib
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import psutil

from experiments.trials.journal import NAME

ROOT = Path(__file__).parents[2]
PYTHON = os.environ | {"PYTHONPATH": str(ROOT)}
CLUSTER = """
import sys
from distributed import LocalCluster
if __name__ == "__main__":
    with LocalCluster(
        n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None, host="127.0.0.1"
    ) as cluster:
        print(cluster.scheduler_address, *sorted(worker.pid for worker in cluster.workers.values()), flush=True)
        sys.stdin.read()
"""


def start(arguments: Sequence[str]) -> subprocess.Popen[str]:
    """A command of the product, as a process."""
    return subprocess.Popen(
        [sys.executable, "-m", "cli.main", *arguments],
        cwd=ROOT,
        env=PYTHON,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def wait_for_results(folder: Path, results: int) -> None:
    """Until the folder's journal holds so many."""
    for _ in range(4800):
        with contextlib.suppress(FileNotFoundError):
            if (folder / NAME).read_bytes().count(b"\n") >= results:
                return
        time.sleep(0.025)
    raise AssertionError("no trial was finished within two minutes")


def kill_after(arguments: Sequence[str], folder: Path, results: int, end: signal.Signals) -> None:
    """Run a command until its folder has so many results, then end it; nothing of it may be left."""
    command = start(arguments)
    wait_for_results(folder, results)
    workers = psutil.Process(command.pid).children(recursive=True)
    command.send_signal(end)
    out, err = command.communicate(timeout=20)
    assert out == ""
    if end == signal.SIGINT:
        assert command.returncode == 130
        assert "interrupted; the same command goes on where it stopped" in err
        assert "Traceback" not in err
    _, alive = psutil.wait_procs(workers, timeout=10)
    assert not alive


@contextmanager
def dask_cluster(folder: Path) -> Iterator[str]:
    """The address of a Dask scheduler with two workers that are processes of their own."""
    script, log = folder / "cluster.py", folder / "log"
    script.write_text(CLUSTER, encoding="utf-8")
    with log.open("w") as errors:
        process = subprocess.Popen(
            [sys.executable, str(script)],
            env=PYTHON,
            cwd=folder,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=errors,
            text=True,
        )
    assert process.stdin is not None
    assert process.stdout is not None
    address, *workers = process.stdout.readline().split() or [log.read_text()]
    assert len(set(workers)) == 2, address
    family = psutil.Process(process.pid).children(recursive=True)
    try:
        yield address
    finally:
        process.stdin.close()
        process.stdout.close()
        process.wait(30)
        _, alive = psutil.wait_procs(family, timeout=10)
        assert not alive
