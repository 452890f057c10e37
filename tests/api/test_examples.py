"""Every example runs, in an empty folder, and prints what it is about."""

import json
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
    "03_own_body": "largest distance error after 15 s: ",
    "04_sweep_with_bands": "nash against no messages",
    "05_listen_with_zenoh": "robot 1 is at",
    "06_break_links_on_a_schedule": "t = 10.0 s: the plan is 0.01 s old",
    "07_read_a_result": "<Result of triangle-circle with nash",
    "08_notebook": "cut at 10 s: ",
}


def script(name: str, folder: Path) -> Path:
    """The example, or the code of its notebook's cells."""
    file = ROOT / "examples" / f"{name}.py"
    if file.exists():
        return file
    cells = json.loads(file.with_suffix(".ipynb").read_text("utf-8"))["cells"]
    code = ["".join(cell["source"]) for cell in cells if cell["cell_type"] == "code"]
    (folder / file.name).write_text("\n".join(code), encoding="utf-8")
    return folder / file.name


def test_every_example_is_run() -> None:
    assert {file.stem for file in (ROOT / "examples").iterdir() if file.suffix in (".py", ".ipynb")} == set(PRINTS)


@pytest.mark.processes
@pytest.mark.parametrize("name", PRINTS)
def test_an_example_runs_in_an_empty_folder(name: str, tmp_path: Path, runs: Path) -> None:
    done = subprocess.run(
        [sys.executable, str(script(name, tmp_path))],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert PRINTS[name] in done.stdout
