"""Laws of scripts: no process of ours begins them again, whether they guard their work or not."""

import subprocess
import sys
from pathlib import Path

import pytest

from tests.processes.live import runs

__all__ = ["runs"]
ROOT = Path(__file__).parents[2]
LAUNCH = """
with echelon.launch("circle", {"duration": 0.3}, page=False) as run:
    run.wait()
    print(len(run.result().inputs))
"""
STUDY = """
print(len(echelon.study("circle", {"duration": 0.3}, grid={"link.latency": [0, 0.3]}, seeds=1, workers=2)))
"""
OWN = """
class Still:
    def __init__(self, task, options): ...
    def plan(self, observation): ...
echelon.load("circle", controller=Still)
"""
CHILD = """
import multiprocessing
if __name__ == "__main__":
    process = multiprocessing.get_context("spawn").Process(target=print)
    process.start()
    process.join()
else:
    for start in (echelon.launch, lambda: echelon.study("circle", grid={"seed": [1]})):
        try:
            start()
        except echelon.EchelonError as error:
            print(str(error).partition(";")[0], flush=True)
"""


def run(folder: Path, text: str) -> "subprocess.CompletedProcess[str]":
    """Run a script that says when it begins."""
    script = folder / "script.py"
    script.write_text(
        f"import sys; sys.path.append({str(ROOT)!r})\nimport echelon\nprint('begins', flush=True)\n{text}"
    )
    return subprocess.run([sys.executable, script], capture_output=True, text=True, check=False, timeout=120)


@pytest.mark.processes
@pytest.mark.parametrize(("text", "printed"), [(LAUNCH, "30"), (STUDY, "2")])
def test_a_script_without_a_guard_runs_once(text: str, printed: str, tmp_path: Path, runs: Path) -> None:
    done = run(tmp_path, text)
    assert done.stdout.split() == ["begins", printed], done.stderr


def test_a_script_that_loads_a_class_of_its_own_without_a_guard_is_refused_in_one_line(tmp_path: Path) -> None:
    done = run(tmp_path, OWN)
    wanted = 'expected a file that does its work below `if __name__ == "__main__":`'
    assert wanted in done.stderr.splitlines()[-1]
    assert "RecursionError" not in done.stderr


@pytest.mark.processes
def test_a_process_that_imports_the_script_starts_none_of_ours(tmp_path: Path, runs: Path) -> None:
    lines = run(tmp_path, CHILD).stdout.splitlines()
    below = 'expected a script that does its work below `if __name__ == "__main__":`'
    assert [line for line in lines if line not in ("begins", "")] == [f"launch: {below}", f"study: {below}"]
