"""What the words of `echelon control` mean, and how it answers to those that mean nothing."""

from typing import Any

import pytest

from cli.main import main, whole_parser


@pytest.mark.parametrize(
    ("words", "missing"),
    [("move", "ROBOT, DX, DY"), ("move 3", "DX, DY"), ("move 3 0.1", "DY"), ("goto 1", "Y"), ("drive", "V, OMEGA")],
)
def test_a_number_that_is_missing_is_named(words: Any, missing: Any, capsys: Any) -> None:
    """Python 3.11 cannot name an argument of two values: that was a TypeError."""
    with pytest.raises(SystemExit) as ended:
        main(["control", *words.split()])
    assert ended.value.code == 2
    assert f"the following arguments are required: {missing} (" in capsys.readouterr().err


@pytest.mark.parametrize("dx", ["-2e-2", "-.5", "-5", "-1E+3", "-inf", "-5cm"])
def test_a_minus_and_a_digit_begin_a_value(dx: Any) -> None:
    parsed = whole_parser().parse_args(["control", "move", "3", dx, "0.1"])
    assert (parsed.robot, parsed.dx, parsed.dy) == ("3", dx, "0.1")


@pytest.mark.parametrize(("option", "value"), [("--loss", "-5%"), ("--latency", "-5ms"), ("--latency", "-1e-3s")])
def test_an_option_takes_such_a_value_too_and_its_bound_is_told(option: Any, value: Any, capsys: Any) -> None:
    assert main(["fault", "set", "--link", "1->2", option, value]) == 2
    assert f"expected at least 0; got {value!r}" in capsys.readouterr().err


@pytest.mark.parametrize("words", ["speed x", "speed xx", "kill agent-", "leave robot", "push robot- gust", "step x"])
def test_what_is_no_number_is_shown_as_it_was_written(words: Any, capsys: Any) -> None:
    """Not as what is left of it without its prefix: of `speed x` that was nothing."""
    assert main(["control", *words.split()]) == 2
    action, value = words.split()[:2]
    assert f"{action}: expected a number; got {value!r}" in capsys.readouterr().err


def test_a_scenario_that_does_not_exist_is_told_that_a_file_would_do(capsys: Any) -> None:
    assert main(["control", "scenario", "nope"]) == 2
    assert "triangle-corner, FILE.toml; got 'nope'" in capsys.readouterr().err
