"""Compiled kernels belong to sources and machine, not to a path; where nothing can be written they stay private."""

import os
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from agents.kernels import jit_cache
from formation.errors import EchelonError
from runtime.precompile import ensure_compiled

ROOT = Path(__file__).parents[3]
KERNEL = """
from agents.kernels.jit import REAL, kernel_for

@kernel_for(REAL, REAL)
def twice(x: float) -> float:
    return 2.0 * x
"""
COUNT = "from agents.kernels.tiny import twice; print(twice(21.0), sum(twice.stats.cache_hits.values()))"


def checkout(folder: Path) -> Path:
    """Sources with one small kernel, at another path and with other time stamps."""
    for part in ("agents/__init__.py", "agents/kernels/__init__.py", "agents/kernels/jit.py"):
        (folder / part).parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(ROOT / part, folder / part)
    shutil.copyfile(ROOT / "agents/kernels/jit_cache.py", folder / "agents/kernels/jit_cache.py")
    (folder / "formation/clear").mkdir(parents=True)
    for name in ("__init__", "errors", "unicycle", "clear/stopping"):
        shutil.copyfile(ROOT / f"formation/{name}.py", folder / f"formation/{name}.py")
    (folder / "agents/kernels/tiny.py").write_text(KERNEL)
    return folder


def run(folder: Path, cache: Path, code: str = COUNT, **variables: str) -> list[str]:
    environment = {**os.environ, "PYTHONPATH": str(folder), "ECHELON_CACHE": str(cache), **variables}
    command = [sys.executable, "-c", code]
    done = subprocess.run(command, capture_output=True, text=True, check=True, env=environment, cwd=folder)
    return done.stdout.split()


def test_kernels_of_one_checkout_serve_every_other_one(tmp_path: Path) -> None:
    here, there, cache = checkout(tmp_path / "here"), checkout(tmp_path / "there"), tmp_path / "cache"
    os.utime(there / "agents/kernels/tiny.py", (1e9, 1e9))
    assert run(here, cache) == ["42.0", "0"]
    assert run(there, cache) == ["42.0", "1"]
    (there / "agents/kernels/tiny.py").write_text(KERNEL.replace("2.0 * x", "3.0 * x"))
    assert run(there, cache) == ["63.0", "0"]
    for name in ("unicycle", "clear/stopping"):
        called = there / f"formation/{name}.py"
        called.write_text(called.read_text() + "# a change in what kernels call\n")
        assert run(there, cache) == ["63.0", "0"]


def test_what_cannot_be_written_is_copied_to_a_private_folder_and_loaded_there(tmp_path: Path) -> None:
    here, built, temporary = checkout(tmp_path / "here"), tmp_path / "built", tmp_path / "tmp"
    temporary.mkdir()
    note = "import agents.kernels.tiny; from agents.kernels.jit_cache import note_compiled as n; n()"
    assert run(here, built, note) == []
    (blocked := tmp_path / "file").write_text("not a folder")
    variables = {"TMPDIR": str(temporary), "ECHELON_PREBUILT": str(built)}
    assert run(here, blocked, COUNT, **variables) == ["42.0", "1"]
    (kept,) = temporary.iterdir()
    assert kept.stat().st_mode & 0o777 == 0o700
    assert not list((here / "agents/kernels").glob("__pycache__/*.nbi"))


@pytest.fixture
def blocked(tmp_path: Path, monkeypatch: Any) -> Path:
    """A place that cannot be written, and an empty temporary folder beside it."""
    (tmp_path / "file").write_text("not a folder")
    (tmp_path / "tmp").mkdir()
    monkeypatch.setenv("ECHELON_CACHE", str(tmp_path / "file"))
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path / "tmp"))
    return tmp_path / "file"


def test_the_user_reads_that_a_cache_cannot_be_written(blocked: Path, monkeypatch: Any) -> None:
    said: list[str] = []
    monkeypatch.setattr("runtime.precompile.KERNEL_MODULES", ["sys"])
    ensure_compiled(said.append)
    assert str(blocked) in said[0]
    assert str(jit_cache.cache_folder()) in said[0]
    assert "ECHELON_CACHE" in said[0]
    assert jit_cache.cache_folder().is_relative_to(blocked.parent / "tmp")


@pytest.mark.parametrize("mode", [0o770, 0o702])
def test_a_temporary_folder_that_others_may_write_is_refused(blocked: Path, mode: int) -> None:
    place = jit_cache.cache_folder().parents[1]
    place.chmod(mode)
    with pytest.raises(EchelonError, match="ECHELON_CACHE"):
        jit_cache.cache_folder()
    place.rmdir()
    place.symlink_to(blocked.parent)
    with pytest.raises(EchelonError, match="ECHELON_CACHE"):
        jit_cache.cache_folder()


def test_a_user_without_a_home_gets_a_private_folder(blocked: Path, monkeypatch: Any) -> None:
    def nobody() -> Path:
        raise RuntimeError

    monkeypatch.delenv("ECHELON_CACHE")
    monkeypatch.delenv("XDG_CACHE_HOME", raising=False)
    monkeypatch.setattr(Path, "home", nobody)
    assert jit_cache.cache_folder().is_relative_to(blocked.parent / "tmp")


def test_a_home_of_another_user_and_one_that_is_not_there_are_no_place_for_kernels(
    blocked: Path, monkeypatch: Any
) -> None:
    monkeypatch.delenv("ECHELON_CACHE")
    monkeypatch.setenv("XDG_CACHE_HOME", "beside/whatever/lies/here")
    monkeypatch.setenv("HOME", str(blocked.parent))
    assert jit_cache.wanted_place() == blocked.parent / ".cache"
    monkeypatch.setattr("os.getuid", lambda: blocked.stat().st_uid + 1)
    assert jit_cache.wanted_place() is None
    monkeypatch.undo()
    for variable in ("ECHELON_CACHE", "XDG_CACHE_HOME"):
        monkeypatch.delenv(variable, raising=False)
    monkeypatch.setenv("HOME", str(blocked.parent / "gone"))
    assert jit_cache.wanted_place() is None
    assert not (blocked.parent / "gone").exists()
