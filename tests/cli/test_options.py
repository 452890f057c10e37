"""What commands take from files: faults as a scenario has them, under any spelling of the suffix."""

import argparse
from typing import Any

import pytest

from cli.options import overrides, record_file
from formation.errors import EchelonError, ScenarioError

NOTHING: dict[str, Any] = {"settings": [], "controller": None, "bodies": None, "seed": None}


@pytest.mark.parametrize("name", ["own.toml", "own.TOML"])
def test_faults_come_from_a_file(tmp_path: Any, name: Any) -> None:
    (tmp_path / name).write_text('[[faults]]\nat = 1\nlink = "1->2"\ncut = true\n', encoding="utf-8-sig")
    found = overrides(argparse.Namespace(faults=str(tmp_path / name), **NOTHING))
    assert found == {"faults": [{"at": 1, "link": "1->2", "cut": True}]}


@pytest.mark.parametrize(("name", "words"), [("wify", "wifi, congested"), ("none.toml", "there is no none.toml")])
def test_faults_that_are_neither_a_preset_nor_a_file_are_refused(name: Any, words: Any) -> None:
    with pytest.raises(ScenarioError, match=words):
        overrides(argparse.Namespace(faults=name, **NOTHING))


def test_a_file_without_faults_is_refused() -> None:
    with pytest.raises(ScenarioError, match=r"--faults: expected \[\[faults\]\] tables in /dev/null; got none"):
        overrides(argparse.Namespace(faults="/dev/null", **NOTHING))


def test_a_record_is_a_new_file_that_can_be_written(tmp_path: Any) -> None:
    """Known before the run begins: its recorder would be a process that records nothing."""
    new = tmp_path / "new.mcap"
    assert record_file(argparse.Namespace(record=str(new)), "circle") == new
    assert not new.exists()
    new.touch()
    for file, words in (
        (str(new), "expected the name of a new file"),
        (str(tmp_path / "none" / "new.mcap"), "expected a file in a folder that exists"),
        ("/proc/x.mcap", "cannot write /proc/x.mcap: "),
        (str(tmp_path / ("n" * 300)), "cannot write .*: File name too long"),
    ):
        with pytest.raises(EchelonError, match=f"--record: {words}"):
            record_file(argparse.Namespace(record=file), "circle")
