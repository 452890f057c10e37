"""A study is the same to the last byte on any number of workers and after any interruption; nothing is left behind."""

# mypy: disable-error-code="no-any-return"

import json
import signal
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from experiments.study.grid import trials
from experiments.study.results import run_and_write
from experiments.study.study import Study, load
from experiments.trials import pool
from experiments.trials.batch import Place
from experiments.trials.journal import NAME, Journal
from formation.errors import EchelonError
from runtime.precompile import ensure_compiled
from tests.experiments.killing import ROOT, dask_cluster, kill_after, start

TABLES = ("trials.csv", "trials.parquet", "series.parquet", "summary.csv", "study.json")
FILE = """
name = "tiny"
scenarios = ["triangle-circle"]
overrides = { duration = 1.2, noise = { slip = 0.2, gyro = 0.2, position = 0.001, heading = 0.01 } }
seeds = 3
warmup = "200ms"
measures = ["distance_rms_m", "recovery_s", "clearance_m", "age_max_s", "lost_share"]
[event]
at = 0.5
until = 0.7
below = 1e-9
[[axes]]
name = "controller"
choices = { nash = {}, "nash, \\"fresh\\"" = { controller.age_plans = false } }
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


def simulated(study: Study, folder: Path, *, workers: int | None = 1, cluster: str | None = None) -> Path:
    run_and_write(study, Place(folder, workers, cluster), tell=print, progress=lambda *_: None)
    return folder


@pytest.fixture(scope="module")
def reference(study: Any, tmp_path_factory: Any) -> Path:
    """Simulated by one worker without a break."""
    return simulated(study, tmp_path_factory.mktemp("reference"))


def assert_same(one: Path, other: Path) -> None:
    for name in TABLES:
        assert (one / name).read_bytes() == (other / name).read_bytes(), name
    pictures = sorted(path.name for path in one.iterdir() if path.suffix in {".png", ".svg"})
    assert pictures == ["time.png", "time.svg"]
    for name in pictures:
        assert (one / name).read_bytes() == (other / name).read_bytes(), name


def test_the_tables_do_not_depend_on_the_number_of_workers(study: Any, reference: Any, tmp_path: Any) -> None:
    assert_same(simulated(study, tmp_path / "new" / "folder", workers=2), reference)
    assert not list(tmp_path.rglob("*.part"))


def test_parquet_and_csv_say_the_same(reference: Any) -> None:
    import csv

    import duckdb

    with (reference / "trials.csv").open(encoding="utf-8", newline="") as lines:
        rows = list(csv.DictReader(lines))
    found = duckdb.read_parquet(str(reference / "trials.parquet"))
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
    assert_same(simulated(study, tmp_path), reference)
    (tmp_path / NAME).write_bytes(b"\0\0\xff\n" + b"".join(reversed(lines[4:])) + b"{}\n[]\n")
    assert_same(simulated(study, tmp_path), reference)


def test_other_commands_import_nothing_of_this() -> None:
    code = (
        "import sys, cli.run, cli.main; print([m for m in ('duckdb', 'matplotlib', 'distributed') if m in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_listing_studies_imports_nothing_heavy() -> None:
    code = (
        "import sys, cli.main; cli.main.main(['study', '--list', '--json']);"
        "print([m for m in ('duckdb', 'matplotlib', 'distributed', 'numba') if m in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True)
    assert done.stdout.splitlines()[-1] == "[]"


def test_more_seeds_simulate_the_new_ones_only(study: Any, reference: Any) -> None:
    more, simulated_seeds = study.model_copy(update={"seeds": 4}), []

    def note(work: Any) -> Iterator[Any]:
        for trial in work:
            simulated_seeds.append(trial.seed)
            yield trial, {}

    before = (reference / NAME).read_bytes()
    with Journal(reference) as journal:
        pool.finish(trials(more), journal, note, lambda *_: None)
    (reference / NAME).write_bytes(before)
    assert simulated_seeds == [3] * 4


@pytest.mark.processes
def test_interrupted_and_run_again_it_ends_as_if_nothing_had_been(file: Any, reference: Any, tmp_path: Any) -> None:
    arguments = ["study", str(file), "--out", str(tmp_path), "--workers", "2", "--json"]
    kill_after(arguments, tmp_path, 1, signal.SIGINT)
    assert (tmp_path / NAME).read_bytes().count(b"\n") < 12
    second = start(arguments)
    out, err = second.communicate(timeout=120)
    assert second.returncode == 0, err
    assert " of 12 trials are in " in err
    told = json.loads(out)
    assert told["trials"] == 12
    assert all(Path(name).is_file() for name in told["files"])
    assert_same(tmp_path, reference)


@pytest.mark.processes
def test_a_dask_cluster_of_real_processes_gives_the_same_study(study: Any, reference: Any, tmp_path: Any) -> None:
    with dask_cluster(tmp_path) as address:
        assert_same(simulated(study, tmp_path / "far", workers=None, cluster=address), reference)
        (wrong, *_) = trials(study)
        broken = replace(wrong, name="the broken one", scenario={**wrong.scenario, "duration": "soon"})
        with Journal(tmp_path / "broken") as journal, pytest.raises(EchelonError, match="the broken one: duration"):
            pool.finish([broken], journal, pool.cluster(address), lambda *_: None)
