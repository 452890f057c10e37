"""Laws of the pool: all work once, in its order, whoever does it; a failure is named and the others are kept."""

import contextlib
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import psutil
import pytest

from cli import main as command
from experiments.trials import pool
from experiments.trials.journal import Journal
from formation.errors import EchelonError
from tests.experiments.killing import ROOT


@dataclass(frozen=True)
class Square:
    """Work that can be checked."""

    number: int
    cost: int = 1

    @property
    def name(self) -> str:
        return f"square {self.number}"

    @property
    def key(self) -> str:
        return str(self.number)

    def run(self) -> dict[str, Any]:
        if self.number < 0:
            raise ValueError("negative\nand more")
        return {"square": self.number**2}


def nothing(*_: Any) -> None:
    """No progress."""


def workers_left() -> list[int]:
    """Pool workers of this process that still run some seconds later: who has been ended takes a moment to be gone."""
    found = []
    for child in psutil.Process().children(recursive=True):
        with contextlib.suppress(psutil.Error):
            if "spawn_main" in " ".join(child.cmdline()) and child.status() != psutil.STATUS_ZOMBIE:
                found.append(child)
    _, alive = psutil.wait_procs(found, timeout=10.0)
    return [child.pid for child in alive]


@pytest.mark.parametrize("workers", [1, 2])
def test_results_are_in_the_order_of_the_work_and_no_worker_is_left(workers: Any, tmp_path: Any) -> None:
    work = [Square(number) for number in (3, 1, 2, 3)]  # one of them twice
    with Journal(tmp_path) as journal:
        results = pool.finish(work, journal, pool.local(workers), nothing)
        assert set(journal.results) == {"1", "2", "3"}
    assert results == [{"square": square} for square in (9, 1, 4, 9)]
    assert not workers_left()


def test_what_is_in_the_journal_is_not_done_again(tmp_path: Any) -> None:
    def nobody(_: Any) -> Iterator[Any]:
        raise AssertionError("there is nothing left to do")

    seen: list[tuple[float, int, int, bool]] = []
    with Journal(tmp_path) as journal:
        journal.add("2", {"square": 4})
        results = pool.finish([Square(2), Square(2)], journal, nobody, lambda *told: seen.append(told))
    assert results == [{"square": 4}] * 2
    assert seen == [(0.5, 1, 2, False), (1.0, 2, 2, False)]


def test_progress_is_in_shares_of_the_cost_and_the_longest_comes_first(tmp_path: Any) -> None:
    begun: list[int] = []

    def here(work: Any) -> Iterator[Any]:
        for piece in work:
            begun.append(piece.number)
            yield piece, piece.run()

    seen: list[float] = []
    with Journal(tmp_path) as journal:
        pool.finish([Square(1, 1), Square(2, 3)], journal, here, lambda share, *_: seen.append(share))
    assert begun == [2, 1]
    assert seen == [0.75, 1.0]


def test_work_that_fails_is_named_and_the_others_are_kept(tmp_path: Any) -> None:
    work = [Square(1, 3), Square(-7, 1), Square(2, 2)]
    with Journal(tmp_path) as journal, pytest.raises(EchelonError, match=r"^square -7 failed: ValueError: negative$"):
        pool.finish(work, journal, pool.local(1), nothing)
    assert set(journal.results) == {"1", "2"}
    assert not workers_left()


# ---------------------------------------------------------------------- clusters that are not there

COMMANDS = (["study", "delay"], ["paper"])


@pytest.mark.filterwarnings("ignore::DeprecationWarning")
@pytest.mark.parametrize("words", COMMANDS, ids=lambda words: words[0])
def test_a_cluster_that_is_not_there_is_one_line(words: Any, tmp_path: Any, monkeypatch: Any, capsys: Any) -> None:
    monkeypatch.setattr(pool, "CONNECT_SECONDS", "300ms")
    for address in ("tcp://127.0.0.1:1", "nonsense://1"):
        assert command.main([*words, "--cluster", address, "--out", str(tmp_path)]) == 2
        told = capsys.readouterr()
        assert told.out == ""
        assert told.err.startswith(f"echelon {words[0]}: --cluster: expected a Dask scheduler at {address}; got none")
        assert len(told.err.splitlines()) == 1


@pytest.mark.parametrize("words", COMMANDS, ids=lambda words: words[0])
def test_a_cluster_without_dask_says_how_to_get_it(words: Any, tmp_path: Any, monkeypatch: Any, capsys: Any) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    assert command.main([*words, "--cluster", "tcp://127.0.0.1:1", "--out", str(tmp_path)]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith(f"echelon {words[0]}: --cluster: expected Dask to be installed; got none (python -m pip")


@pytest.mark.parametrize("words", COMMANDS, ids=lambda words: words[0])
@pytest.mark.parametrize(
    ("arguments", "line"),
    [
        (["--workers", "0"], "--workers: expected at least 1; got 0"),
        (["--workers", "1", "--cluster", "tcp://x:1"], "--workers: expected no number with --cluster"),
    ],
)
def test_workers_that_make_no_sense_are_one_line(words: Any, arguments: Any, line: Any, capsys: Any) -> None:
    assert command.main([*words, *arguments]) == 2
    told = capsys.readouterr()
    assert told.out == ""
    assert told.err.startswith(f"echelon {words[0]}: {line}")
    assert len(told.err.splitlines()) == 1


def test_the_version_of_dask_that_is_named_is_the_one_of_the_project() -> None:
    import tomllib

    with (ROOT / "pyproject.toml").open("rb") as text:
        extras = tomllib.load(text)["project"]["optional-dependencies"]
    wanted = f"distributed=={pool.DASK_VERSION}"
    assert extras["cluster"] == [wanted]
    assert wanted in extras["test"]
