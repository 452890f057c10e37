"""Laws of the journal: what was written survives, what is torn is dropped, one writer at a time."""

from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from experiments.trials.journal import NAME, Journal
from formation.errors import EchelonError

RESULTS: dict[str, dict[str, Any]] = {
    "a": {"values": {"x": 1.5}},
    "b": {"values": {"x": None}},
    "c": {"values": {"x": 1e-300}},
}


@pytest.fixture(scope="module")
def whole(tmp_path_factory: Any) -> bytes:
    folder = tmp_path_factory.mktemp("journal")
    with Journal(folder) as journal:
        for key, result in RESULTS.items():
            journal.add(key, result)
    return bytes((folder / NAME).read_bytes())


@given(data=st.data())
def test_cut_anywhere_it_keeps_every_whole_line_and_takes_new_ones(
    whole: Any, tmp_path_factory: Any, data: Any
) -> None:
    size = data.draw(st.integers(0, len(whole)))
    folder = tmp_path_factory.mktemp("cut")
    (folder / NAME).write_bytes(whole[:size])
    kept = whole[:size].count(b"\n")
    with Journal(folder) as journal:
        assert list(journal.results)[:kept] == list(RESULTS)[:kept]
        assert all(RESULTS[key] == result for key, result in journal.results.items())
        journal.add("new", {})
    with Journal(folder) as journal:
        assert set(journal.results) >= {*list(RESULTS)[:kept], "new"}


def test_lines_that_are_no_results_are_passed_over(whole: Any, tmp_path: Any) -> None:
    (tmp_path / NAME).write_bytes(b"\0\0\xff\n{}\n[]\n[1, 2]\n" + whole)
    with Journal(tmp_path) as journal:
        assert journal.results == RESULTS


def test_a_line_that_was_edited_or_damaged_is_no_result(whole: Any, tmp_path: Any) -> None:
    """As JSON it would be one."""
    edited = whole.replace(b"1.5", b"2.5")
    assert edited != whole
    (tmp_path / NAME).write_bytes(edited + b'["d", {"values": {}}]\n')
    with Journal(tmp_path) as journal:
        assert journal.results == {key: result for key, result in RESULTS.items() if key != "a"}


def test_two_commands_cannot_write_into_one_folder(tmp_path: Any) -> None:
    with Journal(tmp_path), pytest.raises(EchelonError, match="another process is writing to"):
        Journal(tmp_path)
    with Journal(tmp_path):
        pass


def test_a_folder_that_cannot_be_written_is_refused(tmp_path: Any) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(EchelonError, match="--out: expected a folder that can be written; got"):
        Journal(tmp_path / "file" / "below")
