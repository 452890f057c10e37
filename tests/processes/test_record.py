"""Records of live runs: whole whatever is killed, and equal to one process to the last bit."""

import json
import os
import random
import resource
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import psutil
import pytest

from records.record import load
from records.repair import repair
from tests.processes.live import Up, echelon, processes, title, wait_for

pytestmark = [pytest.mark.processes]
MOMENTS = int(os.environ.get("ECHELON_MOMENTS", "1"))
"""Of each kind at which processes are killed; tried with 10 too."""


@pytest.mark.usefixtures("runs")
def test_a_record_of_processes_is_the_run_of_one_process(tmp_path: Path) -> None:
    file = tmp_path / "run.mcap"
    setting = "faults=[{at=1, until=2, link='1->2', cut=true}, {link='2->3', loss=0.3}]"
    echelon("run", "triangle-circle", "--set", "duration=3", "--set", setting, f"--record={file}", "--json")
    read = load(file)
    assert read.sound
    assert read.episodes[0].ticks == list(range(301))
    assert "every bit is equal" in echelon("verify", str(file)).stdout


def test_a_run_whose_record_cannot_grow_says_so_and_has_its_measures(runs: Path, tmp_path: Path) -> None:
    def fill() -> None:
        resource.setrlimit(resource.RLIMIT_FSIZE, (1 << 16, 1 << 16))

    file, words = tmp_path / "run.mcap", ("run", "triangle-circle", "--duration", "10", "--json")
    process = command(*words, f"--record={file}", preexec_fn=fill)
    out, err = process.communicate(timeout=120)
    assert process.returncode == 2
    assert json.loads(out)["duration"] == 10.0
    assert f"expected a whole record in {file}; it could not be written to its end" in err
    assert "recorded in" not in err
    assert not list(runs.iterdir())


def test_a_run_whose_recorder_died_says_so(runs: Path, tmp_path: Path) -> None:
    file, words = tmp_path / "run.mcap", ("run", "triangle-circle", "--duration", "6", "--realtime", "--json")
    process = command(*words, f"--record={file}")
    wait_for(file.exists)
    (recorder,) = [one for one in processes(runs) if title(one).endswith(": recorder")]
    recorder.kill()
    _, err = process.communicate(timeout=120)
    assert process.returncode == 2
    assert f"expected a whole record in {file}; its recorder died" in err
    assert file.with_stem("run-2").exists()


def command(*words: str, **options: Any) -> subprocess.Popen[str]:
    cli = [sys.executable, "-m", "cli.main", *words]
    return subprocess.Popen(cli, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, **options)


def victims(run: Up, who: str) -> list[int]:
    if who == "everything":
        return [process.pid for process in processes(run.folder)]
    return [run.process.pid] if who == "launcher" else [run.pid(who)]


@pytest.mark.parametrize("who", ["world", "recorder", "launcher", "everything"] * MOMENTS)
def test_a_record_survives_the_death_of_anything(up: Callable[..., Up], tmp_path: Path, who: Any) -> None:
    file, new = tmp_path / "run.mcap", tmp_path / "new.mcap"
    run = up("--no-dashboard", f"--record={file}", "--set", "duration=60")
    run.running()
    echelon("fault", "set", "--link", "1->2", "--latency", "100ms", "--for", "1s")
    time.sleep(1.0 + random.random())
    before = run.status()
    for pid in victims(run, who):
        psutil.Process(pid).send_signal(signal.SIGKILL)
    if who == "world":  # which begins anew
        wait_for(lambda: (s := run.status()) and s["episode"] != before["episode"] and s["stamp"] > 0.5)
    run.end()
    wait_for(lambda: not processes(run.folder))
    done = repair(file, new)
    assert done.messages > 100
    (episode, *others) = load(new).episodes
    assert episode.number == before["episode"]
    assert episode.ticks[-1] * 0.01 > before["stamp"] - 1.0
    assert len(others) == (who == "world")
    verdict = echelon("verify", str(new)).stdout
    assert verdict.startswith("episode 1:")
    assert "differs" not in verdict
    assert [order.kind for order in episode.orders].count("faults") >= 2


def test_a_recorder_that_died_goes_on_in_another_file(up: Callable[..., Up], tmp_path: Path) -> None:
    run = up("--no-dashboard", f"--record={tmp_path / 'run.mcap'}")
    run.running()
    os.kill(run.pid("recorder"), signal.SIGKILL)
    second = tmp_path / "run-2.mcap"
    wait_for(second.exists)
    wait_for(lambda: "is recorded" in run.text().split("no longer")[-1])
    time.sleep(1.0)
    run.end()
    read = load(second)
    assert read.sound
    assert read.episodes[0].ticks[0] > 0
    assert "every bit is equal" in echelon("verify", str(second)).stdout


MINE = """
import numpy as np

class Mine:
    def __init__(self, task, options):
        pass

    def plan(self, observation):
        return np.tile([0.05, 0.1], (20, 1))
"""


@pytest.mark.usefixtures("runs")
def test_a_record_of_an_own_controller_is_verified_with_that_very_text_only(tmp_path: Path) -> None:
    mine, file = tmp_path / "mine.py", str(tmp_path / "run.mcap")
    mine.write_text(MINE)
    own = ("--controller", f"{mine}:Mine")
    echelon("run", "triangle-circle", "--engine", "inprocess", "--duration", "1", *own, f"--record={file}", "--json")
    assert "every bit is equal" in echelon("verify", file, *own).stdout
    refused = echelon("verify", file, check=2)
    mine.write_text(MINE.replace("0.1", "0.2"))
    changed = echelon("verify", file, *own, check=2)
    for done in (refused, changed):
        assert not done.stdout
        assert "controller Mine: expected mine.py:Mine of SHA-256" in done.stderr


def test_a_live_run_is_recorded_when_its_users_wish(
    up: Callable[..., Up], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PYTHONPATH", str(Path(__file__).parents[2]))
    monkeypatch.chdir(tmp_path)
    live = up("--no-dashboard", "--speed", "4")
    live.running()
    echelon("control", "record", "on")
    (file,) = wait_for(lambda: list(tmp_path.glob("triangle-circle-*.mcap")))
    shown = wait_for(lambda: live.status().get("recording"))
    assert shown["file"] == str(file)
    assert shown["bytes"] > 1000
    echelon("control", "record", "off")
    wait_for(lambda: load(file).sound)
    wait_for(lambda: live.status()["recording"] is None)
    echelon("verify", str(file))
    assert live.process.poll() is None
