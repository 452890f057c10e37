"""Laws of the Python interface: one hash however it is simulated, results that read back, errors that say where."""

import doctest
import importlib
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import echelon
from formation.link_ids import LinkId
from runtime import inprocess
from runtime.precompile import ensure_compiled
from tests.processes.live import runs

__all__ = ["runs"]
ROOT = Path(__file__).parents[2]
SHORT: dict[str, Any] = {"duration": 2, "noise": {"slip": 0.1}, "link": {"loss": 0.2}}
MODULES = ("echelon", "api.scenarios", "api.result", "api.simulation", "api.study", "api.run")


@pytest.mark.processes
def test_simulate_launch_and_the_engine_give_one_hash(runs: Path) -> None:
    scenario = echelon.load("triangle-circle", SHORT)
    result = echelon.simulate(scenario)
    with echelon.launch(scenario, page=False) as run:
        run.wait()
        live = run.result()
    for late in (run.result, run.start, run.pause, run.clear_faults, lambda: run.push(1, "slow")):
        with pytest.raises(echelon.EchelonError, match=r"expected to be asked within its with block; it is over"):
            late()
    assert run.state is not None
    assert live.trajectory_sha256 == result.trajectory_sha256 == inprocess.simulate(scenario)["trajectory_sha256"]
    for name in ("times", "poses", "inputs", "ages", "distance_errors"):
        np.testing.assert_array_equal(getattr(live, name), getattr(result, name))
    assert not list(runs.iterdir())


@pytest.mark.processes
def test_a_run_that_ends_before_is_an_error_and_so_is_a_time_beyond_the_end(runs: Path) -> None:
    with echelon.launch("triangle-circle", {"duration": 60}, page=False, speed=1.0) as run:
        with pytest.raises(echelon.EchelonError, match="expected at most the duration of 60 s"):
            run.wait(until=61.0)
        with pytest.raises(echelon.EchelonError, match="unknown key"):
            run.set_fault("1->2", latancy=1)
        with pytest.raises(echelon.EchelonError, match="seconds: expected a time such as 300ms"):
            run.set_fault("1->2", seconds="x", latency=1)
        run.wait(until=0.5)
        run._ask(importlib.import_module("network.control").Stop())
        with pytest.raises(echelon.EchelonError, match="expected to reach 60 s; it was stopped"):
            run.wait()


@pytest.mark.processes
def test_a_driven_run_is_driven_from_python(runs: Path) -> None:
    with echelon.launch("drive-me", {"duration": 4}, page=False, paused=True) as run:
        run.drive(0.05, 0.0)
        with pytest.raises(echelon.EchelonError, match="omega"):
            run.drive(0.05, float("nan"))
        run.start()
        run.wait()
        result = run.result()
    way = result.poses[-1, :, :2].mean(axis=0) - result.poses[0, :, :2].mean(axis=0)
    assert np.hypot(*way) > 0.1
    with (
        echelon.launch("circle", {"duration": 1}, page=False, paused=True) as run,
        pytest.raises(echelon.EchelonError, match="driven"),
    ):
        run.go_to(1.0, 0.0)


@pytest.mark.processes
def test_a_study_is_a_table_of_trials_with_the_same_noise_for_all() -> None:
    grid = {"link.latency": [0.0, 0.2], "law": {"deaf": {"controller": {"name": "virtual_structure"}}, "nash": {}}}
    table = echelon.study("circle", {"duration": 1, "noise": {"slip": 0.2}}, grid=grid, seeds=2, workers=2)
    assert table.columns[:5] == ["trial", "scenario", "link_latency", "law", "seed"]
    assert len(table) == 8
    deaf = [row for row in table.rows() if row["law"] == "deaf"]
    assert deaf[0]["trajectory_sha256"] == deaf[2]["trajectory_sha256"] != deaf[1]["trajectory_sha256"]
    with pytest.raises(echelon.EchelonError, match=r"link.latancy: unknown key.*latency"):
        echelon.study("circle", grid={"link.latancy": [0.0]})


@pytest.mark.processes
@pytest.mark.parametrize("name", MODULES)
def test_the_examples_of_the_docstrings_are_so(name: str, runs: Path) -> None:
    ensure_compiled(print)
    found = doctest.testmod(importlib.import_module(name))
    assert found.failed == 0
    assert found.attempted > 0


def test_steps_with_a_fault_from_outside_are_the_scenario_with_that_fault() -> None:
    scenario = echelon.load("triangle-circle", {"duration": 2})
    simulation = echelon.Simulation(scenario)
    simulation.step(50)
    simulation.set_fault(LinkId(1, 2), cut=True)
    while not simulation.finished:
        simulation.step(7)
    fault = {"link": "1->2", "at": 0.5, "cut": True}
    there = echelon.simulate(scenario, {"faults": [fault]})
    assert simulation.result().trajectory_sha256 == there.trajectory_sha256
    assert simulation.observation(2).upstream.age == pytest.approx(1.5, abs=0.02)
    assert simulation.state.status == "finished"


def test_a_result_reads_back_and_its_table_has_every_robot_at_every_tick(tmp_path: Path) -> None:
    result = echelon.simulate("triangle-circle", SHORT)
    again = echelon.read(result.to_parquet(tmp_path / "x.parquet"))
    for name in ("poses", "inputs", "ages"):
        np.testing.assert_array_equal(getattr(again, name), getattr(result, name))
    assert again.summary() == result.summary()
    assert again.scenario == result.scenario
    table = result.table()
    assert len(table) == 3 * len(result.times)
    np.testing.assert_array_equal(table["x"][table["robot"] == 2], result.poses[:, 1, 0])
    assert (result.to_csv(tmp_path / "x.csv").read_text().splitlines()[0]).split(",") == table.columns
    assert "arrow_array_stream" in repr(table.__arrow_c_stream__())
    with pytest.raises(echelon.EchelonError, match=r"expected a file of Result.to_parquet"):
        echelon.read(table.to_parquet(tmp_path / "y.parquet"))


def test_a_result_is_drawn_in_a_notebook_and_its_arrays_cannot_be_written(tmp_path: Path) -> None:
    result = echelon.simulate("triangle-circle", {"duration": 1})
    assert 'src="data:image/png;base64,' in result._repr_html_()
    result.plot(tmp_path / "x.png")
    assert (tmp_path / "x.png").read_bytes()[:4] == b"\x89PNG"
    with pytest.raises(ValueError, match="read-only"):
        result.poses[0, 0, 0] = 1.0


@pytest.mark.parametrize(
    ("overrides", "path", "choice"),
    [
        ({"link": {"latancy": 1}}, "link.latancy", "latency"),
        ({"controller": {"name": "nahs"}}, "controller.name", "nash"),
        ({"controller": {"horizn": 1}}, "controller.horizn", "horizon"),
        ({"duration": -1}, "duration", None),
    ],
)
def test_an_error_knows_its_key_and_what_there_is(overrides: Any, path: str, choice: Any) -> None:
    with pytest.raises(echelon.ScenarioError) as caught:
        echelon.load("circle", overrides)
    assert caught.value.path == path
    assert choice in caught.value.choices if choice else not caught.value.choices


def test_a_class_that_is_in_no_file_is_refused() -> None:
    made = type("Made", (), {"__module__": "builtins"})
    with pytest.raises(echelon.ScenarioError, match="expected a class in a file"):
        echelon.load("circle", controller=made)


def python(folder: Path, text: str) -> "subprocess.CompletedProcess[str]":
    """Run a program in a folder that comes first on its path, as a notebook's does."""
    program = f"import sys; sys.path[:0] = ['']; sys.path.append({str(ROOT)!r}); {text}"
    return subprocess.run([sys.executable, "-c", program], cwd=folder, capture_output=True, text=True, check=False)


def test_import_works_beside_files_with_the_names_of_our_rooms_and_of_pythons_modules(tmp_path: Path) -> None:
    (tmp_path / "agents").mkdir()
    for file in ("network.py", "queue.py", "socket.py", "agents/__init__.py", "runtime.py"):
        (tmp_path / file).write_text("raise ValueError('not this one')")
    done = python(tmp_path, "import echelon; print(echelon.simulate('triangle-circle', {'duration': 0.1}).poses.shape)")
    assert done.stdout.strip() == "(11, 3, 3)", done.stderr


def test_a_foreign_module_of_such_a_name_gets_one_line(tmp_path: Path) -> None:
    (tmp_path / "network.py").write_text("")
    done = python(tmp_path, "import network, echelon")
    assert "ImportError: echelon: expected to import its own module network; " in done.stderr.splitlines()[-1]


def test_import_takes_less_than_half_a_second(tmp_path: Path) -> None:
    best = min(_seconds(tmp_path) for _ in range(3))
    assert best < 0.5


def _seconds(folder: Path) -> float:
    began = time.perf_counter()
    assert python(folder, "import echelon").returncode == 0
    return time.perf_counter() - began


def test_every_public_name_is_there_and_described() -> None:
    assert set(dir(echelon)) >= set(echelon.__all__)
    for name in echelon.__all__:
        assert getattr(echelon, name).__doc__, name
    stubs = (ROOT / "echelon-stubs" / "__init__.pyi").read_text()
    assert all(f" as {name}\n" in stubs for name in echelon.__all__)
    with pytest.raises(AttributeError, match=r"expected one of .*simulate"):
        echelon.simulat  # noqa: B018
