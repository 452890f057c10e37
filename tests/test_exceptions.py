"""Laws of what may be absent: on CI nothing is skipped but by the table, and the table gives reasons."""

import re
from pathlib import Path
from typing import Any

import pytest

from tests import exceptions
from tests.exceptions import EXCEPTIONS, NEEDS, Need, needs

ABSENT = Need(lambda: False, "nowhere to be had")


@pytest.fixture(autouse=True)
def absent(monkeypatch: Any) -> None:
    monkeypatch.setitem(NEEDS, "absent", ABSENT)
    monkeypatch.setitem(NEEDS, "present", Need(lambda: True, "here"))


def test_what_is_there_is_no_reason_to_skip() -> None:
    needs("present")


def test_what_is_absent_skips_the_test_and_names_the_remedy(monkeypatch: Any) -> None:
    monkeypatch.delenv("CI", raising=False)
    with pytest.raises(pytest.skip.Exception, match=r"absent.*nowhere to be had"):
        needs("present", "absent")


def test_on_ci_what_is_absent_fails_the_test(monkeypatch: Any) -> None:
    monkeypatch.setenv("CI", "true")
    with pytest.raises(pytest.fail.Exception, match=r"absent.*nowhere to be had"):
        needs("absent")


def test_on_ci_an_exception_skips_with_its_reason(monkeypatch: Any) -> None:
    monkeypatch.setenv("CI", "true")
    monkeypatch.setitem(EXCEPTIONS, "absent", "because it is Thursday")
    with pytest.raises(pytest.skip.Exception, match="because it is Thursday"):
        needs("absent")


def test_every_exception_is_a_need_and_has_a_reason() -> None:
    assert set(EXCEPTIONS) <= set(NEEDS)
    assert all(len(reason) > 20 for reason in EXCEPTIONS.values())


def test_no_test_skips_past_the_table() -> None:
    """A skip, an importorskip or a mark elsewhere would pass on CI without a word."""
    own = {Path(exceptions.__file__), Path(__file__)}
    files = [file for file in Path(__file__).parent.rglob("*.py") if file not in own]
    assert len(files) > 30
    words = re.compile(r"pytest\.(skip|importorskip|mark\.skip)|\bimportorskip\(|unittest\.skip")
    assert not [file.name for file in files if words.search(file.read_text("utf-8"))]
