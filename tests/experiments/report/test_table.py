"""Laws of tables of results: three digits, the same content in every form."""

import csv
import io
import math
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from experiments.report.table import Table, shown

numbers = st.floats(-1e6, 1e6).filter(lambda x: x == 0.0 or abs(x) > 1e-12)


@given(numbers)
def test_a_number_is_shown_to_three_digits(value: Any) -> None:
    text = shown(value).replace("−", "-").replace("×10", "e")
    text = text.translate(str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789"))
    assert float(text) == pytest.approx(value, rel=0.051 if "e" in text else 0.0051)


def test_rounding_up_adds_no_digit() -> None:
    assert [shown(x) for x in (9.999, 99.99, 0.9999, 12345.0)] == ["10.0", "100", "1.00", "12300"]


def test_other_cells_are_words() -> None:
    assert [shown(cell) for cell in (None, True, False, 7, "x", math.inf, 0.0)] == [
        "–",
        "yes",
        "no",
        "7",
        "x",
        "∞",
        "0",
    ]


def test_a_table_says_the_same_in_every_form() -> None:
    table = Table("t", "A <b> & c", ("name, of it", "value"), (("a|b", 1.23456789012), ('"q"', None)))
    assert list(csv.reader(io.StringIO(table.csv()))) == [["name, of it", "value"], ["a|b", "1.23456789"], ['"q"', ""]]
    assert table.markdown().splitlines()[:2] == ["| name, of it | value |", "| --- | ---: |"]
    assert r"a\|b" in table.markdown()
    assert table.json()["rows"] == [["a|b", 1.23456789012], ['"q"', None]]
