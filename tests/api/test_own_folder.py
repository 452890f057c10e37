"""From an empty folder, with the manual alone: the commands of the page on controllers, and types for a user's file."""

import json
import os
import re
import subprocess
import sys
import venv
from pathlib import Path

import pytest

from tests.processes.live import runs

__all__ = ["runs"]
ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "own-controller.md").read_text("utf-8")
COMMANDS = re.findall(r"^echelon (.*)$", PAGE, re.M)


def echelon(folder: Path, *words: str) -> str:
    done = subprocess.run(
        [sys.executable, "-m", "cli.main", *words],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.mark.processes
@pytest.mark.timeout(400)
def test_the_four_commands_of_the_page_do_what_it_says(tmp_path: Path, runs: Path) -> None:
    folder = tmp_path / "empty"
    folder.mkdir()
    new, processes, inprocess, study = (command.split() for command in COMMANDS)
    echelon(folder, *new)
    assert len((folder / "hold_slot.py").read_text().splitlines()) <= 15
    short = ("--duration", "3", "--json")
    found = [json.loads(echelon(folder, *words, *short)) for words in (processes, inprocess)]
    assert {one["controller"] for one in found} == {"HoldSlot"}
    assert len({one["trajectory_sha256"] for one in found}) == 1
    echelon(folder, *study, "--set", "duration=21", "--seeds", "1")
    table = (folder / "results" / "trials.csv").read_text()
    assert ",nash," in table
    assert ",HoldSlot," in table
    assert (folder / "results" / "distance.png").stat().st_size > 1000


def test_the_file_that_new_writes_passes_its_own_test(tmp_path: Path) -> None:
    echelon(tmp_path, "new", "controller", "HoldSlot")
    done = subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "test_hold_slot.py"],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout


USER = """\
import echelon

scenario = echelon.load("triangle-circle", {"duration": 2})
result: echelon.Result = echelon.simulate(scenario, seed=1)
reveal_type(result.trajectory_sha256)
with echelon.launch(scenario, page=False) as run:
    run.wait(until=1.0)
    reveal_type(run.page)
echelon.simulate(3)
"""


def test_types_reach_a_users_file_outside_the_repository(tmp_path: Path) -> None:
    home = tmp_path / "venv"
    venv.create(home, with_pip=False)
    places = [str(ROOT), *(path for path in sys.path if path.endswith("site-packages"))]
    (next((home / "lib").glob("python*")) / "site-packages" / "echelon.pth").write_text("\n".join(places))
    (tmp_path / "use.py").write_text(USER)
    words = ["--strict", "--cache-dir", str(tmp_path / "cache"), "--python-executable", str(home / "bin" / "python")]
    done = subprocess.run(
        [sys.executable, "-m", "mypy", *words, "use.py"],
        cwd=tmp_path,
        env={key: value for key, value in os.environ.items() if key not in ("PYTHONPATH", "MYPYPATH")},
        capture_output=True,
        text=True,
        check=False,
    )
    lines = [line for line in done.stdout.splitlines() if line.startswith("use.py")]
    assert [re.sub(r"^use.py:", "", line)[:20] for line in lines if "note" not in line] == ["9: error: Argument 1"], (
        done.stdout
    )
    assert done.stdout.replace("builtins.", "").count('Revealed type is "str"') == 2
