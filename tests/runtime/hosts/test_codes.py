"""Laws of codes: good once, for a while, for one run, however they are typed."""

from pathlib import Path
from typing import Any

import pytest

from formation.errors import EchelonError
from runtime.hosts import codes
from runtime.hosts.authority import Authority
from runtime.hosts.codes import GUESTS, LETTERS, LIFE_SECONDS, Codes, mark, split

AUTHORITY = Authority().pem


@pytest.fixture
def kept(tmp_path: Path) -> Codes:
    return Codes(tmp_path)


@pytest.mark.parametrize("guest", GUESTS)
def test_a_code_lets_in_what_it_is_for_and_only_once(kept: Codes, tmp_path: Path, guest: Any) -> None:
    code = kept.new(guest, AUTHORITY)
    known, secret = split(code)
    assert known == mark(AUTHORITY)
    assert secret not in (tmp_path / codes.FILE).read_text()
    assert (tmp_path / codes.FILE).stat().st_mode & 0o777 == 0o600
    assert kept.redeem(secret) == guest
    with pytest.raises(EchelonError, match="used already"):
        kept.redeem(secret)
    kept.give_back(secret)
    assert Codes(tmp_path).redeem(secret) == guest


def test_a_code_is_good_for_ten_minutes(kept: Codes, monkeypatch: pytest.MonkeyPatch) -> None:
    now = 1000.0
    monkeypatch.setattr(codes, "monotonic", lambda: now)
    first, second = (split(kept.new("agents", AUTHORITY))[1] for _ in range(2))
    now += LIFE_SECONDS - 1.0
    assert kept.redeem(first) == "agents"
    now += 2.0
    with pytest.raises(EchelonError, match="older than ten minutes"):
        kept.redeem(second)


def test_a_code_may_be_typed_in_any_way_and_has_no_letters_that_look_alike(kept: Codes) -> None:
    code = kept.new("operator", AUTHORITY)
    assert split(code.lower().replace("-", " ")) == split(code) == split(code.replace("-", ""))
    assert len(LETTERS) == 32
    assert not set("0O1I") & set(LETTERS)
    for wrong in ("", code[:-1], f"{code}A", f"{code[:-1]}0", "ÄBCD" * 5):
        with pytest.raises(EchelonError, match="20 letters"):
            split(wrong)


def test_what_is_no_code_of_the_run_lets_nobody_in(kept: Codes) -> None:
    kept.new("agents", AUTHORITY)
    with pytest.raises(EchelonError, match="this one is none"):
        kept.redeem("ABCDEFGH")
    assert mark(Authority().pem) != mark(AUTHORITY)
