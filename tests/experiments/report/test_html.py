"""Laws of the report's page: what is text stays text."""

from html.parser import HTMLParser

from matplotlib.figure import Figure

from experiments.report.html import html, inline
from experiments.report.report import Picture, Report, Section, Verdict
from experiments.report.table import Table

NASTY = "<script>alert(1)</script> & \" '"


class Tags(HTMLParser):
    """Names of all tags and the text between them."""

    def __init__(self, page: str) -> None:
        super().__init__()
        self.tags: list[str] = []
        self.text = ""
        self.alts: list[str | None] = []
        self.feed(page)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)
        self.alts += [value for name, value in attrs if name == "alt"]

    def handle_data(self, data: str) -> None:
        self.text += data


def test_text_is_escaped_before_it_is_marked_up() -> None:
    assert inline("**a<b** `x&y` [z](#w)") == '<strong>a&lt;b</strong> <code>x&amp;y</code> <a href="#w">z</a>'
    assert "<a" not in inline("[z](https://example.org)")


def test_nothing_that_is_reported_becomes_markup() -> None:
    blocks = (
        NASTY,
        Table("t", NASTY, (NASTY, "value"), ((NASTY, 1.0),)),
        Picture("p", Figure(), NASTY, NASTY),
        Verdict(NASTY, NASTY, "holds"),
    )
    page = html(Report(NASTY, (NASTY,), (Section("s", NASTY, blocks),)), lambda _: b"<svg/>")
    seen = Tags(page)
    assert "script" not in seen.tags
    # title, heading, lead; the section in contents, at a glance and as heading; text; table: caption, head, cell;
    # caption of the picture; claim at a glance; claim; found
    assert seen.text.count(NASTY) == 14
    assert seen.alts == [NASTY]


def test_numbers_stand_right_and_sections_below_the_second_level_are_indented() -> None:
    table = Table("t", "caption", ("name", "value"), (("a", 1.0),))
    page = html(Report("title", (), (Section("s", "deep", (table,), level=3),)), lambda _: b"")
    assert '<td>a</td><td class="number">1.00</td>' in page
    assert '<li class="deep"><a href="#s">deep</a></li>' in page
    assert "<h3>deep</h3>" in page
