"""The shell's completion offers every command, every option, and the names that there are."""

import shutil
import subprocess
from pathlib import Path
from typing import Any

import pytest

from cli.main import COMMANDS, main
from formation.faults import PRESETS
from formation.scenario.files import shipped
from formation.scenario.registry import names


@pytest.fixture(scope="module")
def script(tmp_path_factory: Any) -> Path:
    if shutil.which("bash") is None:
        pytest.skip("needs bash")
    file: Path = tmp_path_factory.mktemp("shell") / "echelon.bash"
    with pytest.MonkeyPatch.context() as patch:
        lines: list[str] = []
        patch.setattr("builtins.print", lambda text, **_: lines.append(text))
        assert main(["completion", "bash"]) == 0
    file.write_text("\n".join(lines), encoding="utf-8")
    return file


def offered(script: Path, line: str, folder: Path) -> set[str]:
    """What bash offers for the last word of a line."""
    asked = (
        f"source {script}; line={line!r}; read -ra COMP_WORDS <<<\"$line\"; [[ $line == *' ' ]] && COMP_WORDS+=('')\n"
        "COMP_CWORD=$((${#COMP_WORDS[@]} - 1)); COMPREPLY=(); "
        '_shtab_echelon echelon "${COMP_WORDS[COMP_CWORD]}" ""; printf "%s\\n" "${COMPREPLY[@]}"'
    )
    done = subprocess.run(["bash", "-c", asked], capture_output=True, text=True, check=False, timeout=20, cwd=folder)
    assert done.stderr == ""
    return set(done.stdout.split())


def test_every_command_is_offered(script: Any, tmp_path: Any) -> None:
    assert offered(script, "echelon ", tmp_path) == set(COMMANDS)


@pytest.mark.parametrize(
    ("line", "names"),
    [
        ("echelon run x --controller ", names()),
        ("echelon up x --faults ", PRESETS),
        ("echelon control co", ("controller", "compare")),
        ("echelon fault set --l", ("--latency", "--loss", "--link")),
        ("echelon completion ", ("bash", "zsh", "fish")),
    ],
)
def test_options_and_names_are_offered(script: Any, tmp_path: Any, line: Any, names: Any) -> None:
    assert set(names) <= offered(script, line, tmp_path)


def test_a_scenario_is_a_name_or_a_file(script: Any, tmp_path: Any) -> None:
    for name in ("own.toml", "other.TOML", "not.txt"):
        (tmp_path / name).touch()
    assert offered(script, "echelon run ", tmp_path) >= {*shipped(), "own.toml", "other.TOML"}
    assert "not.txt" not in offered(script, "echelon run ", tmp_path)


@pytest.mark.parametrize("shell", ["zsh", "fish"])
def test_other_shells_have_the_names_too(shell: Any, capsys: Any) -> None:
    assert main(["completion", shell]) == 0
    text = capsys.readouterr().out
    assert all(name in text for name in (*COMMANDS, *shipped(), *names()))
