"""A scenario from a pipe, and points and offsets from files, give the same run in both engines."""

import json
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from tests.processes.live import Up, echelon, wait_for

pytestmark = pytest.mark.processes

OWN = """\
name = "own"
duration = 2
[path]
kind = "waypoints"
file = "way.csv"
columns = ["east", "north"]
speed_column = "v"
[formation]
file = "places.csv"
unit = "cm"
[link]
latency = "100ms"
"""
WAY = "time;north;east;v\n" + "".join(f"{i};{0.1 * i * i / 20};{0.1 * i};0.1\n" for i in range(20))
PLACES = "robot,x,y\n1,10,0\n2,0,10\n3,-10,-10\n"


def hashed(folder: Path, command: str) -> str:
    """The trajectory of a command of bash, which knows pipes."""
    words = f"{sys.executable} -m cli.main {command} --json"
    done = subprocess.run(["bash", "-c", words], capture_output=True, text=True, timeout=120, check=False, cwd=folder)
    assert done.returncode == 0, done.stderr
    return str(json.loads(done.stdout)["trajectory_sha256"])


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: Any) -> Path:
    monkeypatch.setenv("PYTHONPATH", str(Path(__file__).parents[2]))
    (tmp_path / "own.toml").write_text(OWN)
    (tmp_path / "way.csv").write_text(WAY)
    (tmp_path / "places.csv").write_text(PLACES)
    return tmp_path


def test_one_scenario_by_file_and_by_pipe_has_one_trajectory_in_both_engines(runs: Path, folder: Any) -> None:
    commands = [
        f"run {where} --engine {engine}"
        for where in ("own.toml", "<(cat own.toml)")
        for engine in ("inprocess", "processes")
    ]
    assert len({hashed(folder, command) for command in commands}) == 1
    assert not list(runs.iterdir())


def test_files_may_be_named_by_an_override(runs: Path, folder: Any) -> None:
    setting = """'path={kind="waypoints", file="way.csv", columns=["east", "north"]}'"""
    hashes = {
        hashed(folder, f"run circle --duration 2 --engine {e} --set {setting}") for e in ("inprocess", "processes")
    }
    assert len(hashes) == 1
    assert not list(runs.iterdir())


def test_a_live_run_returns_to_the_users_own_scenario(up: Callable[..., Up], folder: Any, monkeypatch: Any) -> None:
    monkeypatch.chdir(folder)
    run = up("own.toml", "--port", "0", "--set", "link.latency=0.2")
    assert run.running()["scenario"] == "own"
    echelon("control", "scenario", "circle")
    wait_for(lambda: run.status().get("scenario") == "circle")
    echelon("control", "scenario", "own.toml")
    wait_for(lambda: run.status().get("scenario") == "own")
    assert "expected one of" in echelon("control", "scenario", "own", check=2).stderr
    assert run.end() == 0
