"""Laws of what `echelon run` prints: what there is no figure of is a dash."""

from typing import Any

from cli.main import main
from cli.terminal.figures import figure


def printed(capsys: Any, *words: str) -> list[str]:
    assert main(["run", "triangle-circle", "--engine", "inprocess", "--duration", "3", *words]) == 0
    return str(capsys.readouterr().out).splitlines()


def test_a_robot_that_is_away_all_the_time_that_is_measured_has_a_dash(capsys: Any) -> None:
    lines = printed(capsys, "--set", "membership.changes=[{robot=2,leave=1}]", "--warmup", "2")
    rows = {line[2:9]: [cell.strip() for cell in line.split("│")[2:6]] for line in lines if "robot " in line[:9]}
    assert rows["robot 2"] == ["-"] * 4
    assert all(float(cell) < 1.0 for robot in ("robot 1", "robot 3") for cell in rows[robot])


def test_a_figure_that_there_is_none_of_is_a_dash() -> None:
    assert [figure(value) for value in (None, float("nan"), float("inf"), 0.123456)] == ["-", "-", "-", "0.1235"]
    assert figure(0.0123456, 1e3, ".2f") == "12.35"
