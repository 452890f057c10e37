"""What the code cites is in docs/, what docs/ names is in the code, and nothing outside the repository is cited."""

import ast
import re
from functools import cache
from pathlib import Path

import pytest

from tests.test_architecture import ROOMS

ROOT = Path(__file__).parent.parent
DOCS = ("design.md", "theory.md")
CITATION = re.compile(r"docs/(\w+)\.md(?:,?\s+sections?\s+(\d+)((?:(?:,|\s+and|\s+to)\s+\d+)*))?")
PATH = re.compile(r"`([a-z]\w*(?:/[\w.-]+)*/[\w-]*(?:\.\w+)?)`")
"""A file or folder of the repository, as docs/ names it."""
ELSEWHERE = re.compile(
    r"\b(?:DESIGN|THEORY|BODIES|HOUSE|HOSTS|VISER|ZENOH)\b[^\n]{0,10}?(?:\.md|section|\d)|\bdesign/[A-Z]"
)


def sources() -> list[Path]:
    """Every text of the repository that may cite."""
    folders = [*ROOMS, "tests", "benchmarks", "scenarios", "studies"]
    found = [file for folder in folders for file in (ROOT / folder).rglob("*.*") if file.suffix in (".py", ".toml")]
    return [*found, ROOT / "README.md", *(ROOT / "docs" / name for name in DOCS)]


@cache
def sections(page: str) -> set[int]:
    """Numbers of a page's sections."""
    return {int(number) for number in re.findall(r"^## (\d+)\. ", (ROOT / "docs" / page).read_text("utf-8"), re.M)}


def citations(text: str) -> list[tuple[str, int | None]]:
    """Every page that a text cites, with the section."""
    found: list[tuple[str, int | None]] = []
    for page, first, more in CITATION.findall(text):
        numbers = [first, *re.findall(r"\d+", more)] if first else [None]
        found += [(f"{page}.md", int(number) if number else None) for number in numbers]
    return found


@pytest.mark.parametrize("page", DOCS)
def test_sections_are_numbered_from_1_without_gaps(page: str) -> None:
    numbers = re.findall(r"^## (.*)$", (ROOT / "docs" / page).read_text("utf-8"), re.M)
    assert [title.split(". ")[0] for title in numbers] == [str(n) for n in range(1, len(numbers) + 1)]


def test_a_citation_is_read_with_its_sections() -> None:
    text = "see docs/theory.md, section 5; docs/design.md, sections 1 and 9. docs/theory.md"
    assert citations(text) == [("theory.md", 5), ("design.md", 1), ("design.md", 9), ("theory.md", None)]


def test_every_section_that_is_cited_exists() -> None:
    found = {(file, *one) for file in sources() for one in citations(file.read_text("utf-8"))}
    assert len(found) > 15
    wrong = [
        f"{file.relative_to(ROOT)}: {page}, section {number}"
        for file, page, number in found
        if page not in DOCS or (number is not None and number not in sections(page))
    ]
    assert not wrong


def test_nothing_outside_the_repository_is_cited() -> None:
    files = [file for file in sources() if file != Path(__file__)]
    assert not [file.relative_to(ROOT) for file in files if ELSEWHERE.search(file.read_text("utf-8"))]
    assert ELSEWHERE.search("(THEORY section 5)")
    assert ELSEWHERE.search("design/VISER.md")


@pytest.mark.parametrize("page", DOCS)
def test_every_file_that_a_page_names_exists(page: str) -> None:
    named = set(PATH.findall((ROOT / "docs" / page).read_text("utf-8")))
    assert len(named) > 5
    assert not [name for name in named if not (ROOT / name).exists()]


def addresses() -> list[tuple[str, str, str]]:
    """Rows of the table "Where to find what": what, file, name."""
    text = (ROOT / "docs" / "design.md").read_text("utf-8").split("Where to find what")[1]
    return re.findall(r"^\| (\w[^|]*) \| `([^`]+)` \| `(\w+)` \|$", text, re.M)


def test_ten_things_that_a_newcomer_looks_for_have_an_address() -> None:
    assert len(addresses()) >= 10


@pytest.mark.parametrize(("what", "file", "name"), addresses())
def test_what_a_newcomer_looks_for_is_defined_where_the_table_says(what: str, file: str, name: str) -> None:
    body = ast.parse((ROOT / file).read_text("utf-8")).body
    defined = {one.name for one in body if isinstance(one, ast.FunctionDef | ast.ClassDef)}
    defined |= {
        target.id
        for one in body
        if isinstance(one, ast.Assign)
        for target in one.targets
        if isinstance(target, ast.Name)
    }
    assert name in defined, what
