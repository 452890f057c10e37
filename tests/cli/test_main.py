"""Laws of every command: its help stands, and whoever has read enough of its output hears no complaint."""

import json
import subprocess
import sys
from typing import Any

import pytest

from cli.main import COMMANDS, main, whole_parser
from formation.scenario.json_schema import json_schema
from formation.scenario.keys import keys


@pytest.mark.parametrize("command", COMMANDS)
def test_every_command_has_a_help(command: Any, capsys: Any) -> None:
    with pytest.raises(SystemExit) as ended:
        main([command, "--help"])
    assert ended.value.code == 0
    assert f"usage: echelon {command}" in capsys.readouterr().out


def test_the_whole_parser_knows_what_each_command_takes() -> None:
    parser = whole_parser()
    assert parser.parse_args(["run", "circle", "--json"]).json
    assert parser.parse_args(["fault", "set", "--loss", "30%"]).loss == "30%"


@pytest.mark.parametrize(
    ("words", "line"),
    [
        ("study --seeds x", "argument --seeds: expected a whole number; got 'x'"),
        ("up --port 8.5", "argument --port: expected a whole number; got '8.5'"),
        ("up --speed fast", "argument --speed: expected a number; got 'fast'"),
        ("recording agent file --robot x", "argument --robot: expected a whole number; got 'x'"),
        ("run circle --warmup 2x", "argument --warmup: expected a time such as 300ms, 0.3s or 2min; got '2x'"),
    ],
)
def test_what_is_no_number_is_told_with_what_was_expected(words: str, line: str, capsys: Any) -> None:
    with pytest.raises(SystemExit) as ended:
        main(words.split())
    assert ended.value.code == 2
    assert f"{line} (" in capsys.readouterr().err


def test_a_warmup_is_a_time_as_the_duration_is() -> None:
    parse = whole_parser().parse_args
    assert [parse(["run", "--warmup", text]).warmup for text in ("2", "2s", "500ms", "1min")] == [2.0, 2.0, 0.5, 60.0]


def test_the_schema_and_the_keys_are_printed_as_they_are(capsys: Any) -> None:
    assert main(["schema"]) == 0
    assert json.loads(capsys.readouterr().out) == json_schema()
    assert main(["scenarios", "--keys", "--json"]) == 0
    assert [key["path"] for key in json.loads(capsys.readouterr().out)["keys"]] == [key.path for key in keys()]
    assert main(["scenarios", "--keys", "arena"]) == 0
    text = capsys.readouterr().out
    assert "bodies.arena" in text
    assert "[m]" in text
    assert main(["scenarios", "--keys", "latncy"]) == 2
    assert "expected a part of a key" in capsys.readouterr().err


def test_a_reader_that_has_enough_ends_it_quietly() -> None:
    command = f"{sys.executable} -m cli.main schema | head -1"
    done = subprocess.run(["bash", "-c", command], capture_output=True, text=True, check=False, timeout=60)
    assert done.stdout == "{\n"
    assert done.stderr == ""


def test_no_command_loads_what_its_processes_are_for() -> None:
    """A launcher that loaded numba with all kernels was half a second late, and nothing else showed it."""
    heavy = {"numba", "matplotlib", "viser", "scipy", "mujoco", "pyarrow"}
    code = (
        "import sys; from cli.main import whole_parser; whole_parser(); "
        f"print(*sorted({heavy!r}.intersection(sys.modules)))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60, check=True)
    assert done.stdout.split() == []
