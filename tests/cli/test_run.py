"""Laws of what `echelon run` prints: what there is no figure of is a dash, and what it says of errors is so."""

from typing import Any

import pytest

from cli.main import main
from cli.run import excursions
from cli.terminal.figures import figure


def printed(capsys: Any, *words: str) -> list[str]:
    assert main(["run", "triangle-circle", "--engine", "inprocess", "--duration", "3", *words]) == 0
    return str(capsys.readouterr().out).splitlines()


def test_a_robot_that_is_away_all_the_time_that_is_measured_has_a_dash(capsys: Any) -> None:
    lines = printed(capsys, "--set", "membership.changes=[{robot=2,leave=1}]", "--warmup", "2")
    rows = {line[2:9]: [cell.strip() for cell in line.split("│")[2:6]] for line in lines if "robot " in line[:9]}
    assert rows["robot 2"] == ["-"] * 4
    assert all(float(cell) < 1.0 for robot in ("robot 1", "robot 3") for cell in rows[robot])


def test_the_line_on_errors_says_what_is_so(capsys: Any) -> None:
    """Of robots that never came into place the ledger has no excursion."""
    near, far = (printed(capsys, *words) for words in ([], ["--set", "robots.start_noise.position=100"]))
    assert "no error above 2 mm once robots were within it" in near
    assert "no robot came within 2 mm of where it should be" in far


@pytest.mark.parametrize(
    ("found", "never", "line"),
    [
        ([], [1, 2], "no error above 2 mm once robots were within it; never within 2 mm: robot 1, robot 2"),
        (
            [{"robot": 3, "peak_m": 0.0051, "t": 2.0, "cause": "none found"}],
            [2],
            "1 excursions above 2 mm; largest: robot 3, 5.1 mm from t = 2.00 s on; likely cause: none found; "
            "never within 2 mm: robot 2",
        ),
    ],
)
def test_who_never_came_into_place_is_named(found: list[Any], never: list[int], line: str) -> None:
    robots = dict.fromkeys(("1", "2", "3"))
    summary = {"excursions": found, "excursion_limit_m": 0.002, "never_within": never, "robots": robots}
    assert excursions(summary) == line


def test_a_figure_that_there_is_none_of_is_a_dash() -> None:
    assert [figure(value) for value in (None, float("nan"), float("inf"), 0.123456)] == ["-", "-", "-", "0.1235"]
    assert figure(0.0123456, 1e3, ".2f") == "12.35"
