"""A share of `benchmarks.bodies --equal-jitter`, and laws of its search."""

import json
import math
import sys
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

import pytest

from benchmarks import bodies, equal_jitter
from benchmarks.bodies_cells import paired_ratio
from benchmarks.rivals import RIVALS, Knob, Tuned
from experiments.trials.pool import Work


def here(work: Sequence[Work]) -> Iterator[tuple[Work, dict[str, Any]]]:
    for piece in work:
        yield piece, piece.run()


def test_two_cells_are_tuned_and_compared(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """On one seed, which shows nothing but that the command works: another seed may end the other way."""
    monkeypatch.setattr(bodies, "local", lambda _: here)
    monkeypatch.setattr(equal_jitter, "ROUNDS", 2)
    cells = ["--rows", "A", "--networks", "late", "--rivals", "virtual_structure,consensus"]
    seeds = ["--tuning", "0:1", "--seeds", "1000:1001", "--out", str(tmp_path)]
    monkeypatch.setattr(sys, "argv", ["bodies", "--equal-jitter", *cells, *seeds])
    code = bodies.main()
    lines = capsys.readouterr().out.splitlines()
    assert [line.split()[:3] for line in lines[:2]] == [["A", "late", "virtual_structure"], ["A", "late", "consensus"]]
    assert code == int(any("WORSE" in line for line in lines[:2]))

    monkeypatch.setattr(bodies, "local", lambda _: lambda _: pytest.fail("the journal has every result"))
    monkeypatch.setattr(sys, "argv", ["bodies", "--equal-jitter", "--json", *cells, *seeds])
    assert bodies.main() == code
    found = json.loads(capsys.readouterr().out)
    assert [row["equal"] for row in found["rows"]] == [True, True]
    assert (found["tuning"], found["seeds"]) == ([0], [1000])


@pytest.mark.parametrize("rival", ["leader_follower", "virtual_structure"])
def test_every_rival_gets_estimates(rival: str) -> None:
    """The shipped one of raw poses is 16 mm off."""
    assert Tuned("A", "on time", rival, 1.0, 0.3, 0).run()["l_e"] < 8.0


@pytest.mark.parametrize(
    ("jitter", "ends"),
    [
        (lambda x: 0.5 - 0.3 * x, 0.5 / 0.3),
        (lambda x: 0.4 - 0.1 * x - 0.2 * x**3, None),
        (lambda x: -0.2 - 0.001 * x, -math.log(1000.0)),
        (lambda x: 0.9 - 0.4 * math.tanh(x), math.log(1000.0)),
    ],
)
def test_a_search_ends_at_equal_jitter_or_at_its_bound(jitter: Callable[[float], float], ends: float | None) -> None:
    knob = Knob(-0.3, equal_jitter.NEAR, equal_jitter.BOUND)
    for _ in range(equal_jitter.ROUNDS):
        knob.tell(jitter(knob.at))
    assert knob.settled
    assert abs(jitter(knob.at)) <= equal_jitter.NEAR or abs(knob.at) == pytest.approx(equal_jitter.BOUND)
    if ends is not None:
        assert knob.at == pytest.approx(ends, abs=0.3)


def test_a_ratio_of_equal_values_is_one_without_an_error() -> None:
    assert paired_ratio([1.0, 2.0, 3.0], [2.0, 4.0, 6.0]) == pytest.approx((0.5, 0.0))


def test_sight_is_compared_where_robots_see_each_other() -> None:
    plan = equal_jitter.Plan(["A", "G"], ["late"], list(RIVALS), [0], [1])
    assert [row for row, _, rival in plan.cells() if rival == "virtual_structure sees"] == ["G"]
