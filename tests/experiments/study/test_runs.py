"""A study is the same to the last byte whoever flies it and however often it is interrupted; nothing is left behind."""

# mypy: disable-error-code="no-any-return"

import contextlib
import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import psutil
import pytest

from cli import main as command
from experiments.study import grid, runner
from experiments.study.flights import Result, simulate
from experiments.study.journal import NAME, Journal
from experiments.study.results import run_and_write
from experiments.study.study import Study, load
from formation.errors import StudyError
from runtime.precompile import ensure_compiled

TABLES = ("flights.csv", "flights.parquet", "series.parquet", "summary.csv", "study.json")
FILE = """
name = "tiny"
scenarios = ["triangle-circle"]
settings = ["duration=1.2", "noise={slip=0.2, gyro=0.2, position=0.001, heading=0.01}"]
seeds = 3
warmup = "200ms"
measures = ["distance_rms_m", "recovery_s", "clearance_m", "age_max_s", "lost_share"]
[event]
at = 0.5
until = 0.7
below = 1e-9
[[axes]]
name = "controller"
choices = { nash = [], "nash, \\"fresh\\"" = ["controller.age_plans=false"] }
[[axes]]
name = "loss"
key = "link.loss"
values = [0.0, 0.5]
[baseline]
loss = 0.0
[[figures]]
name = "time"
kind = "recovery"
by = "controller"
panels = "loss"
"""


@pytest.fixture(scope="module", autouse=True)
def _compiled() -> None:
    ensure_compiled(print)


@pytest.fixture(scope="module")
def file(tmp_path_factory: Any) -> Path:
    made = tmp_path_factory.mktemp("study") / "tiny.toml"
    made.write_text(FILE, encoding="utf-8")
    return made


@pytest.fixture(scope="module")
def study(file: Any) -> Study:
    return load(str(file))


def flown(study: Study, folder: Path, *, workers: int = 1, cluster: str | None = None) -> Path:
    run_and_write(study, folder, workers=workers, cluster=cluster, tell=print, progress=lambda *_: None)
    return folder


@pytest.fixture(scope="module")
def reference(study: Any, tmp_path_factory: Any) -> Path:
    """TrialResult by one worker without a break."""
    return flown(study, tmp_path_factory.mktemp("reference"))


def assert_same(one: Path, other: Path) -> None:
    for name in TABLES:
        assert (one / name).read_bytes() == (other / name).read_bytes(), name
    pictures = sorted(path.name for path in one.iterdir() if path.suffix in {".png", ".svg"})
    assert pictures == ["time.png", "time.svg"]
    for name in pictures:
        assert (one / name).read_bytes() == (other / name).read_bytes(), name


def workers_alive() -> list[int]:
    """Pool workers of this process that still run."""
    found = []
    for child in psutil.Process().children(recursive=True):
        with contextlib.suppress(psutil.Error):
            if "spawn_main" in " ".join(child.cmdline()) and child.status() != psutil.STATUS_ZOMBIE:
                found.append(child.pid)
    return found


def test_the_tables_do_not_depend_on_the_number_of_workers(study: Any, reference: Any, tmp_path: Any) -> None:
    assert_same(flown(study, tmp_path / "new" / "folder", workers=2), reference)
    assert not list(tmp_path.rglob("*.part"))
    assert not workers_alive()


def test_parquet_and_csv_say_the_same(reference: Any) -> None:
    import csv

    import duckdb

    with (reference / "flights.csv").open(encoding="utf-8", newline="") as lines:
        rows = list(csv.DictReader(lines))
    found = duckdb.read_parquet(str(reference / "flights.parquet"))
    assert found.columns == list(rows[0])
    assert len(rows) == 12
    for row, same in zip(rows, found.fetchall(), strict=True):
        assert [None if text == "" else text for text in row.values()] == [
            None if value is None else str(value) for value in same
        ]
    assert {row["controller"] for row in rows} == {"nash", 'nash, "fresh"'}
    assert {row["recovery_s"] for row in rows} == {""}  # nobody is exact to a nanometre


def test_a_journal_cut_anywhere_is_completed_to_the_same_study(study: Any, reference: Any, tmp_path: Any) -> None:
    whole = (reference / NAME).read_bytes()
    lines = whole.splitlines(keepends=True)
    # A torn line in the middle of a number, and garbage that a crash of the machine may leave.
    (tmp_path / NAME).write_bytes(b"".join(lines[:7]) + lines[7][: len(lines[7]) // 2])
    assert_same(flown(study, tmp_path), reference)
    (tmp_path / NAME).write_bytes(b"\0\0\xff\n" + b"".join(reversed(lines[4:])) + b"{}\n[]\n")
    assert_same(flown(study, tmp_path), reference)


def test_what_has_been_flown_is_not_flown_again(study: Any, reference: Any) -> None:
    jobs, done = grid.jobs(study), list[grid.Job]()

    def nobody(_: Any) -> Iterator[Result]:
        raise AssertionError("there is nothing left to fly")

    with Journal(reference) as journal:
        results = runner.finish(jobs, journal, nobody, done.append)
    assert len(results) == len(done) == len(jobs)


def test_more_seeds_fly_the_new_ones_only(study: Any, reference: Any) -> None:
    more = study.model_copy(update={"seeds": 4})
    flew = []

    def count(jobs: Any) -> Iterator[Result]:
        for job in jobs:
            flew.append(job.seed)
            yield Result(job.key, dict.fromkeys(study.measures, 0.0), "", ())

    with Journal(reference) as journal:
        before = (reference / NAME).read_bytes()
        runner.finish(grid.jobs(more), journal, count, lambda _: None)
    (reference / NAME).write_bytes(before)
    assert flew == [3] * 4


def test_two_studies_cannot_write_into_one_folder(tmp_path: Any) -> None:
    with Journal(tmp_path), pytest.raises(StudyError, match="another study is being flown into"):
        Journal(tmp_path)
    Journal(tmp_path).__exit__(None, None, None)


def test_a_folder_that_cannot_be_written_is_told(tmp_path: Any) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(StudyError, match="--out: expected a folder that can be written; got"):
        Journal(tmp_path / "file" / "below")


def test_a_flight_that_fails_is_named_and_the_others_are_kept(study: Any, tmp_path: Any) -> None:
    jobs = grid.jobs(study)[:3]
    broken = grid.Job(0, jobs[1].cell, 7, "{", jobs[1].measuring, jobs[1].code, jobs[1].cost - 1)
    with (
        Journal(tmp_path) as journal,
        pytest.raises(StudyError, match=r"the flight triangle-circle, controller nash, loss 0.0, seed 7 failed: Valid"),
    ):
        runner.finish([jobs[0], broken, jobs[2]], journal, runner.local(1), lambda _: None)
    assert set(journal.results) == {jobs[0].key, jobs[2].key}
    assert not workers_alive()


# ---------------------------------------------------------------------- the command, killed and interrupted


def start(file: Path, folder: Path) -> subprocess.Popen[str]:
    root = str(Path(runner.__file__).parents[2])
    arguments = ["study", str(file), "--out", str(folder), "--workers", "2", "--json"]
    return subprocess.Popen(
        [sys.executable, "-m", "cli.main", *arguments],
        cwd=root,
        env=os.environ | {"PYTHONPATH": root},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def wait_for_lines(folder: Path, lines: int) -> None:
    for _ in range(2400):
        with contextlib.suppress(FileNotFoundError):
            if (folder / NAME).read_bytes().count(b"\n") >= lines:
                return
        time.sleep(0.025)
    raise AssertionError("no flight was finished within a minute")


@pytest.mark.processes
@pytest.mark.parametrize("end", [signal.SIGKILL, signal.SIGINT])
def test_interrupted_and_run_again_it_ends_as_if_nothing_had_been(
    file: Any, reference: Any, tmp_path: Any, end: Any
) -> None:
    first = start(file, tmp_path)
    wait_for_lines(tmp_path, 1)
    workers = psutil.Process(first.pid).children(recursive=True)
    first.send_signal(end)
    out, err = first.communicate(timeout=20)
    assert out == ""
    if end == signal.SIGINT:
        assert first.returncode == 130
        assert "interrupted; the same command goes on where it stopped" in err
        assert "Traceback" not in err
    _, alive = psutil.wait_procs(workers, timeout=10)
    assert not alive
    assert (tmp_path / NAME).read_bytes().count(b"\n") < 12
    second = start(file, tmp_path)
    out, err = second.communicate(timeout=120)
    assert second.returncode == 0, err
    assert " of 12 flights are in " in err
    told = json.loads(out)
    assert told["flights"] == 12
    assert all(Path(name).is_file() for name in told["files"])
    assert_same(tmp_path, reference)


# ---------------------------------------------------------------------- a Dask cluster


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


@pytest.fixture
def cluster(tmp_path: Any) -> Iterator[str]:
    """The address of a Dask scheduler with two workers that are processes of their own."""
    script = tmp_path / "cluster.py"
    script.write_text(CLUSTER, encoding="utf-8")
    root = str(Path(runner.__file__).parents[2])
    log = (tmp_path / "log").open("w+")
    process = subprocess.Popen(
        [sys.executable, str(script)],
        env=os.environ | {"PYTHONPATH": root},
        cwd=tmp_path,
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=log,
        text=True,
    )
    assert process.stdin is not None
    assert process.stdout is not None
    address, *workers = process.stdout.readline().split() or [(tmp_path / "log").read_text()]
    log.close()
    assert len(set(workers)) == 2, address
    family = psutil.Process(process.pid).children(recursive=True)
    yield address
    process.stdin.close()
    process.stdout.close()
    process.wait(30)
    _, alive = psutil.wait_procs(family, timeout=10)
    assert not alive


@pytest.mark.processes
def test_a_dask_cluster_of_real_processes_gives_the_same_study(
    study: Any, reference: Any, tmp_path: Any, cluster: Any
) -> None:
    assert_same(flown(study, tmp_path / "far", cluster=cluster), reference)
    broken = grid.jobs(study)[0]
    broken = grid.Job(0, broken.cell, 7, "{", broken.measuring, broken.code, 1)
    with Journal(tmp_path / "broken") as journal, pytest.raises(StudyError, match="seed 7 failed: Validation"):
        runner.finish([broken], journal, runner.cluster(cluster), lambda _: None)


@pytest.mark.filterwarnings("ignore::DeprecationWarning")
def test_a_cluster_that_is_not_there_is_one_line(file: Any, tmp_path: Any, monkeypatch: Any, capsys: Any) -> None:
    monkeypatch.setattr(runner, "CONNECT_SECONDS", "300ms")
    for address in ("tcp://127.0.0.1:1", "nonsense://1"):
        assert command.main(["study", str(file), "--cluster", address, "--out", str(tmp_path)]) == 2
        told = capsys.readouterr()
        assert told.out == ""
        assert told.err.startswith(f"echelon study: --cluster: expected a Dask scheduler at {address}; got none")
        assert len(told.err.splitlines()) == 1


def test_a_cluster_without_dask_says_how_to_get_it(file: Any, tmp_path: Any, monkeypatch: Any, capsys: Any) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    assert command.main(["study", str(file), "--cluster", "tcp://127.0.0.1:1", "--out", str(tmp_path)]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith("echelon study: --cluster: expected Dask to be installed; got none (python -m pip install")


def test_the_version_of_dask_that_is_named_is_the_one_of_the_project() -> None:
    import tomllib

    with (Path(runner.__file__).parents[2] / "pyproject.toml").open("rb") as text:
        extras = tomllib.load(text)["project"]["optional-dependencies"]
    wanted = f"distributed=={runner.DASK_VERSION}"
    assert extras["cluster"] == [wanted]
    assert wanted in extras["test"]


# ---------------------------------------------------------------------- what it costs others


def test_other_commands_import_nothing_of_this() -> None:
    code = (
        "import sys, cli.run, cli.main; print([m for m in ('duckdb', 'matplotlib', 'distributed') if m in sys.modules])"
    )
    root = str(Path(runner.__file__).parents[2])
    done = subprocess.run([sys.executable, "-c", code], cwd=root, capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_listing_studies_imports_nothing_heavy() -> None:
    code = (
        "import sys, cli.main; cli.main.main(['study', '--list', '--json']);"
        "print([m for m in ('duckdb', 'matplotlib', 'distributed', 'numba') if m in sys.modules])"
    )
    root = str(Path(runner.__file__).parents[2])
    done = subprocess.run([sys.executable, "-c", code], cwd=root, capture_output=True, text=True, check=True)
    assert done.stdout.splitlines()[-1] == "[]"


def test_a_flight_is_flown_by_a_plain_function_of_its_job(study: Any, reference: Any) -> None:
    job = grid.jobs(study)[5]
    with Journal(reference) as journal:
        assert journal.results[job.key] == simulate(job)
