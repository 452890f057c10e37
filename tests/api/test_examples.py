"""Every example runs, in an empty folder, and prints what it is about."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.processes.live import runs

__all__ = ["runs"]
ROOT = Path(__file__).parents[2]
PRINTS = {
    "01_simulate_and_plot": "largest distance error",
    "02_own_controller": "True",
    "06_break_links_on_a_schedule": "t = 10.0 s: the plan is 0.01 s old",
    "07_read_a_result": "<Result of triangle-circle with nash",
}


def test_every_example_is_run() -> None:
    assert {file.stem for file in (ROOT / "examples").iterdir() if file.suffix in (".py", ".ipynb")} == set(PRINTS)


@pytest.mark.processes
@pytest.mark.parametrize("name", PRINTS)
def test_an_example_runs_in_an_empty_folder(name: str, tmp_path: Path, runs: Path) -> None:
    done = subprocess.run(
        [sys.executable, str(ROOT / "examples" / f"{name}.py")],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert PRINTS[name] in done.stdout
