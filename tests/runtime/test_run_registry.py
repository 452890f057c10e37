"""Laws of the list of live runs: a name and a page's port belong to one run, and nothing is left of a claim."""

import contextlib
import itertools
import threading
from pathlib import Path
from typing import Any

import pytest

from formation.errors import EchelonError
from runtime.run_registry import Claim, live

PAGE = "http://127.0.0.1:8090"


@pytest.fixture
def runs(tmp_path: Path, monkeypatch: Any) -> Path:
    monkeypatch.setenv("ECHELON_RUNS", str(tmp_path))
    return tmp_path


def test_the_port_of_a_page_is_taken_before_anything_listens_there(runs: Path) -> None:
    with Claim("one", page=PAGE):
        with pytest.raises(EchelonError, match="8090, which run one has"):
            Claim("two", page=f"{PAGE}/?token=x")
        with Claim("three", page="http://127.0.0.1:8091"), Claim("four"), Claim("five"):
            assert {run.name for run in live()} == {"one", "three", "four", "five"}
    with Claim("two", page=PAGE):
        pass
    assert not list(runs.iterdir())


def test_a_claim_that_cannot_be_entered_leaves_nothing(runs: Path, monkeypatch: Any) -> None:
    def full(*_: Any, **__: Any) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("pathlib.Path.write_text", full)
    with pytest.raises(EchelonError, match="No space left"):
        Claim("one")
    assert not list(runs.iterdir())


def test_nothing_is_left_of_a_run_whose_world_still_writes(runs: Path) -> None:
    """A launcher that is killed leaves the folder to the router, while the world goes on saving there for a moment."""
    written, enough = threading.Event(), threading.Event()

    def save(folder: Path) -> None:
        with contextlib.suppress(FileNotFoundError):
            for number in itertools.takewhile(lambda _: not enough.is_set(), itertools.count()):
                (folder / f"save-{number}").touch()
                written.set()

    for _ in range(20):
        written.clear()
        enough.clear()
        with Claim("one") as claim:
            world = threading.Thread(target=save, args=(claim.path,))
            world.start()
            written.wait()
        enough.set()
        world.join()
        assert not list(runs.iterdir())
