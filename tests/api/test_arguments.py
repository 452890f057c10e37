"""Laws of what callers hand in: numbers of NumPy's are numbers, and what is wrong is one line of an EchelonError."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import echelon
from api.arguments import plain, whole
from formation.schema import time_of

TINY: dict[str, Any] = {"duration": 0.1}
GRID: dict[str, Any] = {"link.latency": [0.0]}


def begun() -> echelon.Simulation:
    simulation = echelon.Simulation(echelon.load("triangle-circle", {"duration": 1}))
    simulation.step(10)
    return simulation


WRONG: list[tuple[Callable[[], Any], str]] = [
    (lambda: echelon.load({"duration": 3}), r"scenario: expected a name, a TOML file or a Scenario; got {'duration'"),  # type: ignore[arg-type]
    (lambda: echelon.simulate(3), "scenario: expected a name"),  # type: ignore[arg-type]
    (lambda: echelon.launch({}), "scenario: expected a name"),  # type: ignore[arg-type]
    (lambda: echelon.load("circle", [1]), "overrides: expected nested data"),  # type: ignore[arg-type]
    (lambda: echelon.load("circle", controller=3), "controller: expected a name, FILE.py:CLASS or a class; got 3"),  # type: ignore[arg-type]
    (lambda: echelon.load("circle", bodies=3), "bodies: expected a name, FILE.py:CLASS or a class; got 3"),  # type: ignore[arg-type]
    (lambda: echelon.simulate("circle", TINY, warmup=float("nan")), "warmup: expected a finite number; got nan"),
    (lambda: begun().result(warmup=float("inf")), "warmup: expected a finite number; got inf"),
    (lambda: begun().step(-1), "ticks: expected an integer, at least 0; got -1"),
    (lambda: begun().step(1.5), "ticks: expected an integer, at least 0; got 1.5"),  # type: ignore[arg-type]
    (lambda: begun().observation("x"), "robot: expected an integer, at least 1; got 'x'"),  # type: ignore[arg-type]
    (lambda: begun().push(True, "gust"), "robot: expected a whole number; got True"),
    (
        lambda: echelon.launch("circle", TINY, speed=float("nan")),
        "speed: expected 0 .as fast as possible. to 1000; got nan",
    ),
    (lambda: echelon.study("circle", TINY, grid={"seed": 3}), "grid: expected values of seed"),  # type: ignore[dict-item]
    (lambda: echelon.study("circle", TINY, grid=GRID, workers=-1), "workers: expected an integer, at least 1; got -1"),
    (lambda: echelon.study("circle", TINY, grid=GRID, measures="x"), "measures: expected a list of names; got 'x'"),
]


@pytest.mark.parametrize(("do", "line"), WRONG)
def test_what_is_wrong_is_one_line(do: Callable[[], Any], line: str) -> None:
    with pytest.raises(echelon.EchelonError, match=line) as caught:
        do()
    assert "\n" not in str(caught.value)


def test_files_that_cannot_be_written_or_read_are_one_line(tmp_path: Path) -> None:
    result = echelon.simulate("triangle-circle", {"duration": 1})
    gone = tmp_path / "gone"
    for write, suffix in ((result.to_csv, "csv"), (result.to_parquet, "parquet"), (result.plot, "png")):
        with pytest.raises(echelon.EchelonError, match=f"expected a file in a folder that exists; there is no {gone}"):
            write(gone / f"x.{suffix}")
    with pytest.raises(echelon.EchelonError, match="expected a file that can be written"):
        result.to_csv(tmp_path)
    with pytest.raises(echelon.EchelonError, match="expected a file that can be written; Format 'nope'"):
        result.plot(tmp_path / "x.nope")
    for name in (tmp_path, gone / "x.parquet"):
        with pytest.raises(echelon.EchelonError, match=r"expected a file of Result.to_parquet; there is none"):
            echelon.read(name)


def test_a_file_whose_name_is_a_pattern_is_read_alone(tmp_path: Path) -> None:
    result = echelon.simulate("circle", TINY)
    result.to_parquet(tmp_path / "a.parquet")
    assert len(echelon.read(result.to_parquet(tmp_path / "*.parquet")).poses) == len(result.poses)


def test_numbers_of_numpys_and_paths_are_taken(tmp_path: Path) -> None:
    (tmp_path / "mine.toml").write_text((Path(__file__).parents[2] / "scenarios" / "triangle-circle.toml").read_text())
    one = echelon.Simulation(echelon.load(tmp_path / "mine.toml", {"duration": 1}))
    other = begun()
    one.step(np.int64(10))  # type: ignore[arg-type]
    one.push(np.int64(1), "gust", seconds=np.float64(0.3))  # type: ignore[arg-type]
    other.push(1, "gust", seconds=0.3)
    one.move(np.uint8(2), np.float64(0.02), 0.0)  # type: ignore[arg-type]
    other.move(2, 0.02, 0.0)
    one.set_fault("1->2", latency=np.float64(0.1), keep_order=np.bool_(True))
    other.set_fault("1->2", latency=0.1, keep_order=True)
    for simulation in (one, other):
        simulation.step(90)
    assert one.result().trajectory_sha256 == other.result().trajectory_sha256


def test_times_and_integers() -> None:
    assert (time_of("x", "300ms"), time_of("x", 2), whole("x", np.int8(3), 0)) == (0.3, 2.0, 3)
    assert plain({"a": np.float32(0.5), "b": {"c": np.bool_(True)}, "d": "e"}) == {"a": 0.5, "b": {"c": True}, "d": "e"}
    assert type(plain(np.int64(3))) is int
