"""Laws of loading code of users' own: what is named, what is beside it, what is said when it cannot be had."""

import hashlib
import sys
from pathlib import Path
from typing import Any

import pytest

from formation.errors import ScenarioError
from formation.loading.load import PACKED, load, names_code, unpack
from formation.loading.source import from_json


def written(folder: Path, **texts: str) -> Path:
    """Python files of a new folder."""
    folder.mkdir(exist_ok=True, parents=True)
    for name, text in texts.items():
        (folder / f"{name}.py").write_text(text)
    return folder


def test_two_files_of_one_name_are_two_modules_each_with_what_lies_beside_it(tmp_path: Path) -> None:
    text = "import helper\nclass Mine:\n    value = helper.VALUE\n"
    found = []
    for value in (1, 2):
        folder = written(tmp_path / str(value), mine=text, helper=f"VALUE = {value}\n")
        found.append(load(f"{folder}/mine.py:Mine", "controller"))
    assert [cls.value for _, cls in found] == [1, 2]  # type: ignore[attr-defined]
    assert len({source.sha256 for source, _ in found}) == 2
    assert "helper" not in sys.modules
    assert "mine" not in sys.modules


def test_the_hash_of_a_file_alone_is_that_of_its_bytes(tmp_path: Path) -> None:
    text = "class Mine:\n    pass\n"
    source, _ = load(f"{written(tmp_path, mine=text)}/mine.py:Mine", "controller")
    assert source.sha256 == hashlib.sha256(text.encode()).hexdigest()


def test_who_gets_the_source_gets_the_text_that_was_read_whatever_became_of_the_files(tmp_path: Path) -> None:
    folder = written(tmp_path / "a", mine="import helper\nclass Mine:\n    value = helper.VALUE\n", helper="VALUE = 1")
    source, _ = load(f"{folder}/mine.py:Mine", "controller")
    written(folder, mine="raise ValueError", helper="VALUE = 2")
    packed = tmp_path / f"x{PACKED}"
    packed.write_text(source.to_json())
    again, cls = load(str(packed), "controller")
    assert (again, cls.value) == (source, 1)  # type: ignore[attr-defined]


def test_a_text_that_is_not_the_one_of_its_hash_is_refused(tmp_path: Path) -> None:
    source, _ = load(f"{written(tmp_path, mine='class Mine: pass')}/mine.py:Mine", "controller")
    with pytest.raises(ScenarioError, match="expected what a launcher wrote"):
        from_json(source.to_json().replace("pass", "None"), "here")


def test_packages_and_relative_imports_beside_a_file_work(tmp_path: Path) -> None:
    written(
        tmp_path / "tools", __init__="from . import deep\n", deep="from .deeper import VALUE\n", deeper="VALUE = 3\n"
    )
    text = "import tools.deeper\nfrom tools import deep\nclass Mine:\n    values = tools.deeper.VALUE, deep.VALUE\n"
    source, cls = load(f"{written(tmp_path, mine=text)}/mine.py:Mine", "controller")
    assert cls.values == (3, 3)  # type: ignore[attr-defined]
    assert set(source.texts) == {"mine.py", "tools/__init__.py", "tools/deep.py", "tools/deeper.py"}
    assert unpack(source)[1].values == (3, 3)  # type: ignore[attr-defined]


def test_a_file_beside_never_replaces_a_module_of_the_product(tmp_path: Path) -> None:
    text = "import network.topics\nimport queue\nclass Mine:\n    topics, queue = network.topics, queue\n"
    folder = written(tmp_path, mine=text, network="raise ValueError", queue="own = True\n")
    cls: Any = load(f"{folder}/mine.py:Mine", "controller")[1]
    assert cls.topics is sys.modules["network.topics"]
    assert cls.queue.own  # of the file; nobody else has it
    assert not hasattr(sys.modules["queue"], "own")


MISTAKES = {
    "{file}": r"expected FILE.py:CLASS; got .*mine.py, which has Mine",
    "{file}:Other": r"expected a class Other; it has Mine",
    "{folder}/none.py:Mine": r"expected a Python file; got none there",
    "{folder}:Mine": r"expected a Python file; got a folder",
    "no_such_module:Mine": r"expected code that can be imported; ModuleNotFoundError: No module named 'no_such_module'",
    "{folder}/raises.py:Mine": r"ZeroDivisionError: division by zero \(raises.py:2\)$",
    "{folder}/wrong.py:Mine": r"SyntaxError: .*\(wrong.py:2\)$",
    "{folder}/exits.py:Mine": r"SystemExit: 3 \(exits.py:1\)$",
    "{folder}/lacks.py:Mine": r"No module named 'not_there' \(lacks.py:1\)$",
    "HoldSlot": r"expected FILE.py:CLASS or package.module:CLASS; got 'HoldSlot'",
    "{file}:": r"expected FILE.py:CLASS",
}


@pytest.mark.parametrize("spec", MISTAKES)
def test_what_cannot_be_had_gets_one_line(spec: str, tmp_path: Path) -> None:
    folder = written(
        tmp_path,
        mine="class Mine: pass\n",
        raises="x = 0\n1 / x\n",
        wrong="x = 0\nclass\n",
        exits="raise SystemExit(3)",
        lacks="import not_there",
    )
    with pytest.raises(ScenarioError, match=MISTAKES[spec]) as mistake:
        load(spec.format(folder=folder, file=folder / "mine.py"), "controller")
    assert "\n" not in str(mistake.value)


def test_a_bom_is_skipped_and_other_encodings_are_named(tmp_path: Path) -> None:
    (tmp_path / "a.py").write_text("class Mine: pass", encoding="utf-8-sig")
    assert load(f"{tmp_path}/a.py:Mine", "controller")[1].__name__ == "Mine"
    (tmp_path / "b.py").write_text("class Mine: pass", encoding="utf-16")
    with pytest.raises(ScenarioError, match="expected text in UTF-8"):
        load(f"{tmp_path}/b.py:Mine", "controller")


def test_names_of_what_is_built_in_name_no_code() -> None:
    assert not names_code("nash", "controller")
    assert not names_code("camera", "bodies")
    assert names_code("./mine.py:X", "controller")
    assert names_code("package.module:X", "controller")
