"""Laws of what reports are made of: statistics, tables, text, figures."""

import csv
import io
import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from experiments.metrics import rms, settled, spread
from experiments.report import style
from experiments.report.html import inline
from experiments.report.table import Table, shown

numbers = st.floats(-1e6, 1e6).filter(lambda x: x == 0.0 or abs(x) > 1e-12)


@given(st.lists(numbers, min_size=1, max_size=50))
def test_a_spread_is_in_order_and_within_its_range(values: Any) -> None:
    found = spread(np.array(values))
    assert found.minimum <= found.lower <= found.median <= found.upper <= found.maximum
    assert (found.minimum, found.maximum) == (min(values), max(values))
    assert found.rms == pytest.approx(math.sqrt(sum(v * v for v in values) / len(values)), abs=1e-9)
    assert found.width >= 0.0


def test_the_rms_of_a_sine_is_its_size_over_root_two() -> None:
    assert rms(np.sin(np.linspace(0.0, 2.0 * np.pi, 10001)[:-1])) == pytest.approx(math.sqrt(0.5))


def test_what_settles_stays_below() -> None:
    times = np.arange(6.0)
    assert settled(times, np.array([5.0, 5.0, 1.0, 5.0, 1.0, 1.0]), 2.0, 0.0) == 4.0
    assert settled(times, np.ones(6), 2.0, 0.0) == 0.0
    assert settled(times, np.array([1.0, 1.0, 1.0, 1.0, 1.0, 5.0]), 2.0, 0.0) is None


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
    assert "A &lt;b&gt; &amp; c" in table.html()
    assert "<b>" not in table.html()
    assert table.json()["rows"] == [["a|b", 1.23456789012], ['"q"', None]]


def test_text_is_escaped_before_it_is_marked_up() -> None:
    assert inline("**a<b** `x&y` [z](#w)") == '<strong>a&lt;b</strong> <code>x&amp;y</code> <a href="#w">z</a>'
    assert "<a" not in inline("[z](https://example.org)")


def test_a_figure_is_a_function_of_what_is_drawn(tmp_path: Any) -> None:
    def drawn(name: str, height: float) -> list[bytes]:
        with style.styled():
            figure = style.figure(2.0)
            axes = figure.subplots()
            axes.plot([0.0, 1.0], [0.0, height], label="line")
            style.outside_legend(axes)
            return [file.read_bytes() for file in style.save(figure, tmp_path / name, "seed 0")]

    assert drawn("a", 1.0) == drawn("b", 1.0)
    assert drawn("a", 1.0) != drawn("b", 2.0)


def test_the_users_own_matplotlib_settings_do_not_matter_and_are_left_alone() -> None:
    import matplotlib as mpl

    with mpl.rc_context({"font.size": 31.0}):
        with style.styled():
            assert mpl.rcParams["font.size"] == 9
        assert mpl.rcParams["font.size"] == 31.0


def test_controllers_have_colours_that_differ() -> None:
    assert len(set(style.CONTROLLERS.values())) == len(style.CONTROLLERS)
    assert style.colour("b", ["a", "b"]) == style.PALETTE[1]
    assert style.colour("nobody") == style.GREY
