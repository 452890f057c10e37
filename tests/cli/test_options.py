"""What commands take from files: faults as a scenario has them, under any spelling of the suffix."""

import argparse
from typing import Any

import pytest

from cli.options import overrides
from formation.errors import ScenarioError

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
