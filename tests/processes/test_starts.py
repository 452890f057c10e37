"""A table of starts: wherever the command is started from, this checkout's code runs and no other."""

import json
import os
import resource
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from tests.processes.live import echelon, processes

pytestmark = pytest.mark.processes
ROOT = Path(__file__).parents[2]
CLI = [sys.executable, "-m", "cli.main"]
FOREIGN = ("network", "queue", "socket", "pickle", "threading", "numpy", "agents/__init__", "world/__init__")
"""Modules that a folder of the user may hold: names of ours, of Python's own modules, of packages."""
RUN = ("run", "triangle-circle", "--duration", "0.1", "--json")
PYTHON = """#!/bin/sh
case "$*" in *"-m pip"*) echo "pip, user $PIP_USER" >> {log}; exit 0;; esac
exec {python} "$@"
"""
"""Stands for the Python of a checkout's .venv: its packages are installed already, those of another checkout."""


@pytest.fixture
def foreign(tmp_path: Path) -> Path:
    """A folder of modules that would leave a mark if they were imported."""
    folder = tmp_path / "foreign"
    for name in FOREIGN:
        file = folder / f"{name}.py"
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(f"open({str(tmp_path / 'mark')!r}, 'a').write({name!r})\nraise ImportError({name!r})\n")
    leave_to_python(folder, tmp_path / "mark")
    return folder


def leave_to_python(folder: Path, mark: Path) -> None:
    """Remove what an installation's own .pth files import from PYTHONPATH before any program has a say."""
    while True:
        bare = ["python3", "-c", ""]
        subprocess.run(bare, capture_output=True, check=False, env={**os.environ, "PYTHONPATH": str(folder)})
        if not mark.exists():
            return
        (folder / f"{mark.read_text()}.py").unlink()
        mark.unlink()


def start(*command: str, folder: Path, path: str) -> subprocess.CompletedProcess[str]:
    """Run a command to its end, in a folder and with a PYTHONPATH."""
    environment = {**os.environ, "PYTHONPATH": path}
    environment.pop("PYTHONSAFEPATH", None)  # set by ./echelon test
    done = subprocess.run(
        command, capture_output=True, text=True, timeout=120, check=False, cwd=folder, env=environment
    )
    assert done.returncode == 0, done.stderr
    assert "Traceback" not in done.stderr
    return done


class Checkout:
    """A checkout of its own: this one's code with a scenario of another name, and a .venv that belongs to this one."""

    def __init__(self, folder: Path) -> None:
        self.folder, self.log = folder, folder.parent / f"{folder.name}-pip.log"
        for entry in ROOT.iterdir():
            if entry.name[0] != "." and entry.name not in ("echelon", "scenarios"):
                (folder / entry.name).parent.mkdir(exist_ok=True)
                (folder / entry.name).symlink_to(entry)
        shutil.copy(ROOT / "echelon", folder)
        shutil.copytree(ROOT / "scenarios", folder / "scenarios")
        self.rename("circle", "only-here")
        self.python = folder / ".venv" / "bin" / "python"
        self.add_python()

    def rename(self, name: str, new: str) -> None:
        """Give a scenario another name: by it the checkout is known."""
        file = self.folder / "scenarios" / f"{name}.toml"
        text = file.read_text().replace(f'name = "{name}"', f'name = "{new}"')
        file.with_stem(new).write_text(text)
        file.unlink()

    def add_python(self) -> None:
        self.python.parent.mkdir(parents=True, exist_ok=True)
        self.python.write_text(PYTHON.format(log=self.log, python=sys.executable))
        self.python.chmod(0o755)

    @property
    def set_up(self) -> int:
        """How often packages were installed."""
        return len(self.log.read_text().splitlines()) if self.log.exists() else 0


@pytest.fixture
def checkout(tmp_path: Path) -> Checkout:
    found = Checkout(tmp_path / "checkout")
    start(str(found.folder / "echelon"), folder=tmp_path, path="")
    assert found.set_up == 1
    return found


def scenarios_of(launcher: Path, folder: Path) -> set[str]:
    done = start(str(launcher), "scenarios", "--json", folder=folder, path="")
    return {scenario["name"] for scenario in json.loads(done.stdout)["scenarios"]}


@pytest.mark.parametrize("way", ["launcher", "console script"])
def test_modules_of_the_current_folder_and_of_pythonpath_are_never_imported(
    runs: Path, checkout: Checkout, foreign: Path, way: str
) -> None:
    """By no process of a live run: the command, the fork server, its helper, and what they start."""
    if way == "launcher":
        done = start(str(checkout.folder / "echelon"), *RUN, folder=foreign, path=str(foreign))
    else:
        done = start(*CLI, *RUN, folder=foreign, path=os.pathsep.join((str(ROOT), str(foreign))))
    assert json.loads(done.stdout)["duration"] == pytest.approx(0.1)
    assert not (foreign.parent / "mark").exists()
    assert not processes(runs)


@pytest.mark.parametrize("what", ["compiler", "workers"])
def test_nor_by_the_compiler_and_the_workers_of_a_study(foreign: Path, tmp_path: Path, what: str) -> None:
    (tmp_path / "program.py").write_text(
        {
            "compiler": "from runtime import precompile\n"
            "precompile.KERNEL_MODULES = ['network.codec', 'numpy']\nprecompile.compiled = lambda: False\n"
            "precompile.note_compiled = lambda: None\nprecompile.ensure_compiled(print)\n",
            "workers": "if __name__ == '__main__':\n"
            "    from experiments.trials.pool import local\n    from tests.experiments.trials.test_pool import Square\n"
            "    print([result for _, result in local(1)([Square(3)])])\n",
        }[what]
    )
    done = start(sys.executable, "-P", str(tmp_path / "program.py"), folder=foreign, path=str(ROOT))
    assert {"compiler": "compiling", "workers": "9"}[what] in done.stdout
    assert not (foreign.parent / "mark").exists()


def test_a_link_elsewhere_starts_the_checkout_that_it_points_to(checkout: Checkout, tmp_path: Path) -> None:
    (tmp_path / "bin").mkdir()
    (tmp_path / "bin" / "echelon").symlink_to(checkout.folder / "echelon")
    assert "only-here" in scenarios_of(tmp_path / "bin" / "echelon", tmp_path)
    assert checkout.set_up == 1


def test_a_folder_that_was_copied_or_renamed_runs_its_own_code(checkout: Checkout, tmp_path: Path) -> None:
    copy = tmp_path / "copy"
    shutil.copytree(checkout.folder, copy, symlinks=True)
    checkout.rename("only-here", "only-there")
    assert {"only-here", "only-there"} & scenarios_of(copy / "echelon", tmp_path) == {"only-here"}
    renamed = checkout.folder.rename(tmp_path / "renamed")
    assert {"only-here", "only-there"} & scenarios_of(renamed / "echelon", tmp_path) == {"only-there"}
    assert checkout.set_up == 1


def test_a_venv_without_its_interpreter_is_made_anew(checkout: Checkout, tmp_path: Path) -> None:
    checkout.python.unlink()
    checkout.python.symlink_to(tmp_path / "gone")
    launcher = checkout.folder / "echelon"
    made = tmp_path / "made"
    text = launcher.read_text()
    assert '"-m", "venv"' in text
    maker = tmp_path / "maker.py"  # to make a real one takes seconds and wants a registry
    maker.write_text(f"import pathlib, sys\npathlib.Path({str(made)!r}).write_text(' '.join(sys.argv))\nsys.exit(1)\n")
    launcher.write_text(text.replace('"-I", "-m", "venv"', f'"-I", {str(maker)!r}'))
    done = subprocess.run([str(launcher)], capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == 2
    assert "Traceback" not in done.stderr
    assert made.read_text().split()[1:] == ["--clear", str(checkout.folder / ".venv")]


def test_what_is_installed_goes_into_the_venv_whatever_pip_is_told_elsewhere(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PIP_USER", "1")
    found = Checkout(tmp_path / "checkout")
    start(str(found.folder / "echelon"), folder=tmp_path, path="")
    assert found.log.read_text() == "pip, user 0\n"


@pytest.mark.parametrize("name", ["a#b", "a?b"])
def test_a_folder_for_runs_in_which_no_socket_can_be_is_refused_in_one_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str
) -> None:
    (tmp_path / name).mkdir()
    monkeypatch.setenv("ECHELON_RUNS", str(tmp_path / name))
    (line,) = echelon(*RUN, check=2).stderr.splitlines()
    assert "without # and ?" in line
    assert "ECHELON_RUNS" in line
    assert [path.name for path in tmp_path.iterdir()] == [name]
    assert not list((tmp_path / name).iterdir())


def test_forty_open_files_are_enough_for_three_robots_and_too_few_is_one_line(runs: Path) -> None:
    def limited(*words: str) -> subprocess.CompletedProcess[str]:
        def limit() -> None:
            resource.setrlimit(resource.RLIMIT_NOFILE, (40, 40))

        return subprocess.run(
            [*CLI, *words], capture_output=True, text=True, timeout=100, check=False, preexec_fn=limit
        )

    done = limited(*RUN)
    assert done.returncode == 0, done.stderr
    done = limited("up", "ring-16", "--no-dashboard", "--together", "1")  # whatever this machine bears
    assert done.returncode == 2
    (line,) = done.stderr.splitlines()
    assert "ulimit -n" in line
    assert not list(runs.iterdir())


@pytest.mark.parametrize("home", ["/proc", "/nowhere/at/all", ""])
def test_without_a_home_libraries_say_nothing(monkeypatch: pytest.MonkeyPatch, home: str, tmp_path: Path) -> None:
    monkeypatch.setenv("HOME", home)
    monkeypatch.delenv("MPLCONFIGDIR", raising=False)
    monkeypatch.delenv("XDG_CONFIG_HOME", raising=False)
    program = "from cli import program; program.begin(); import experiments.report.style"
    assert start(sys.executable, "-c", program, folder=tmp_path, path=str(ROOT)).stderr == ""


def test_doctor_prints_its_table_without_any_package(runs: Path) -> None:
    words = [sys.executable, "-S", "-m", "cli.main", "doctor"]
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    done = subprocess.run(words, capture_output=True, text=True, timeout=60, check=False, env=environment)
    assert done.returncode == 1
    assert done.stderr == ""
    found = dict(line.split(": ", 1) for line in done.stdout.splitlines() if ": " in line)
    assert found["numba"].startswith("not installed, missing (")
    assert "numba" in found["solver"]
    assert {"Python", "cores", "folder for runs", "page"} <= set(found)


def test_doctor_prints_its_table_whatever_the_machine_lacks(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "file").write_text("")
    for variable in ("ECHELON_RUNS", "ECHELON_CACHE", "TMPDIR", "HOME"):
        monkeypatch.setenv(variable, str(tmp_path / "file" / "x"))
    checks = {check["name"]: check for check in json.loads(echelon("doctor", "--json", check=None).stdout)["checks"]}
    assert checks["Python"]["ok"]
    assert not checks["solver"]["ok"]
