"""What the code cites is in docs/, what docs/ names is in the code, and nothing outside the repository is cited."""

import ast
import re
import shlex
import tomllib
from functools import cache
from pathlib import Path
from typing import Any

import pytest
import yaml

from cli.main import whole_parser
from cli.options import load
from docs.generated_pages import PAGES
from experiments.study import study
from experiments.trials.measures import MEASURES
from formation.scenario.files import parse, shipped
from formation.scenario.json_schema import schema_of
from formation.scenario.keys import keys
from network.control import OPERATIONS
from network.topics import MESSAGES
from tests.test_architecture import ROOMS

ROOT = Path(__file__).parent.parent
DOCS = ("design.md", "theory.md")
"""Pages whose sections are numbered and cited."""
PAGES_BY_HAND = sorted(file.name for file in (ROOT / "docs").glob("*.md"))
TEXTS = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *(ROOT / "docs" / name for name in PAGES_BY_HAND)]
LAUNCHER = ("test", "docs")
"""Commands of the script `echelon`, which sets itself up, and not of the program."""
SMALL = {"name": "small", "path": {"kind": "circle"}, "formation": {"shape": "triangle"}}
CITATION = re.compile(r"(?:docs/|\]\()([a-z][a-z-]*)\.md\)?(?:,?\s+sections?\s+(\d+)((?:(?:,|\s+and|\s+to)\s+\d+)*))?")
PATH = re.compile(r"`([a-z]\w*(?:/[\w.-]+)*/[\w-]*(?:\.\w+)?)`")
"""A file or folder of the repository, as docs/ names it."""
MADE = {"site/", "tcp/router:7447", "results/study-NAME", "echelon-paper/report.html"}
"""Named by pages, and made by commands or on other machines."""
ELSEWHERE = re.compile(
    r"\b(?:DESIGN|THEORY|BODIES|HOUSE|HOSTS|VISER|ZENOH)\b[^\n]{0,10}?(?:\.md|section|\d)|\bdesign/[A-Z]"
)


def sources() -> list[Path]:
    """Every text of the repository that may cite."""
    folders = [*ROOMS, "tests", "benchmarks", "scenarios", "studies"]
    found = [file for folder in folders for file in (ROOT / folder).rglob("*.*") if file.suffix in (".py", ".toml")]
    return [*found, *TEXTS]


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
        if page not in (*PAGES_BY_HAND, *PAGES) or (number is not None and number not in sections(page))
    ]
    assert not wrong


def test_nothing_outside_the_repository_is_cited() -> None:
    files = [file for file in sources() if file != Path(__file__)]
    assert not [file.relative_to(ROOT) for file in files if ELSEWHERE.search(file.read_text("utf-8"))]
    assert ELSEWHERE.search("(THEORY section 5)")
    assert ELSEWHERE.search("design/VISER.md")


@pytest.mark.parametrize("file", TEXTS, ids=lambda file: file.name)
def test_every_file_that_a_page_names_exists(file: Any) -> None:
    named = set(PATH.findall(file.read_text("utf-8"))) - MADE
    assert len(named) > 5 or file.name not in DOCS
    assert not [name for name in named if not (ROOT / name).exists()]


def addresses() -> list[tuple[str, str, str]]:
    """Rows of the table "Where to find what": what, file, name."""
    text = (ROOT / "CONTRIBUTING.md").read_text("utf-8").split("Where to find what")[1]
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
    defined |= {one.target.id for one in body if isinstance(one, ast.AnnAssign) and isinstance(one.target, ast.Name)}
    assert name in defined, what


def blocks(file: Path, language: str) -> list[str]:
    """The pieces of code of a language in a page."""
    found = re.findall(rf"^( *)```{language}\n(.*?)^ *```$", file.read_text("utf-8"), re.M | re.S)
    return ["\n".join(line.removeprefix(indent) for line in text.splitlines()) for indent, text in found]


def commands() -> list[tuple[str, list[str]]]:
    """Every call of echelon in a page, as words."""
    found = []
    for file in TEXTS:
        lines = [line for block in blocks(file, "sh") for line in block.splitlines()]
        lines += re.findall(r"`((?:\./)?echelon [^`]+)`", " ".join(file.read_text("utf-8").split()))
        for line in lines:
            words = shlex.split(line, comments=True)
            for start in (i for i, word in enumerate(words) if word in ("echelon", "./echelon")):
                ends = [i for i, word in enumerate(words) if i > start and word in (";", "&&", "|", ">")]
                call = words[start + 1 : min(ends, default=len(words))]
                if call and call[0] not in LAUNCHER and call[0].islower():
                    found.append((f"{file.name}: {' '.join(call)}", call))
    return found


COMMANDS = commands()


def test_there_are_commands_on_the_pages() -> None:
    assert len(COMMANDS) > 40
    assert {call[0] for _, call in COMMANDS} >= {"up", "run", "study", "fault", "control", "scenarios", "compose"}


@pytest.mark.parametrize(("where", "call"), COMMANDS, ids=[where for where, _ in COMMANDS])
def test_a_command_on_a_page_is_one_of_the_program(where: str, call: list[str]) -> None:
    call = [word for word in call if not word.startswith("<(") and word not in ("NAME", "COMMAND", "bash|zsh|fish")]
    found = [word.replace("./generate)", "own.toml") for word in call]
    try:
        options = whole_parser().parse_args(found)
    except SystemExit:
        needs_more = len(found) == 1 or found[-1].isupper()  # named as such: `echelon fault`
        assert needs_more, where
        return
    own = any(".py:" in word for word in found)  # the page's reader has written that file
    if getattr(options, "scenario", None) in shipped() and not own and not {"key=value", "PRESET"} & set(found):
        load(options)  # raises for what is no scenario


@pytest.mark.parametrize("file", TEXTS, ids=lambda file: file.name)
def test_a_key_that_a_page_names_exists(file: Any) -> None:
    known = {re.sub(r"\[\]", "", key.path) for key in keys()}
    tables = {path.partition(".")[0] for path in known if "." in path}
    named = re.findall(r"`([a-z]\w*(?:\.[a-z]\w*)+)(?: ?=[^`]*)?`", file.read_text("utf-8"))
    keys_named = {name for name in named if name.partition(".")[0] in tables and not (ROOT / name).exists()}
    assert not {name for name in keys_named if name not in known and name.rpartition(".")[2] != "py"} - OTHERS


OTHERS = {"robots.N.distance_error_m"}
"""Of the summary, not of a scenario."""


@pytest.mark.parametrize("file", TEXTS, ids=lambda file: file.name)
def test_a_piece_of_toml_on_a_page_is_a_scenario_a_study_or_a_part_of_one(file: Any, tmp_path: Any) -> None:
    (tmp_path / "centreline.csv").write_text("x,y\n0,0\n2,0\n2,2\n0,2\n")
    (tmp_path / "places.csv").write_text("10,0\n0,10\n-10,-10\n")
    for text in blocks(file, "toml"):
        table = tomllib.loads(text)
        if "measures" in table:
            study.parse(table)
        else:
            parse({**SMALL, **table}, folder=tmp_path)


def test_the_page_of_keys_has_every_key_with_what_is_known_of_it() -> None:
    lines = [line for line in PAGES["scenario-keys.md"]().splitlines() if line.startswith("| `")]
    for key in keys():
        if key.type.startswith("table"):
            continue
        found = [
            line for line in lines if line.startswith((f"| `{key.path}` |", f"| `{key.path}` ({', '.join(key.of)}) |"))
        ]
        assert any(all(part in line for part in (key.unit, key.range, key.default)) for line in found), key
        words = max(key.text.replace("|", "\\|").split(), key=len)
        assert any(words in line for line in found), key


def test_the_page_of_study_keys_has_every_key_and_measure() -> None:
    page = PAGES["study-keys.md"]()
    found = keys(schema_of(study.Study))
    assert len(found) > 30
    for key in found:
        assert key.text, key
        assert f"| `{key.path}` |" in page or f"\n## {key.path}\n" in page
    assert all(f"| `{name}` |" in page for name in MEASURES)


def test_the_page_of_messages_has_every_message_field_and_operation() -> None:
    page = PAGES["messages.md"]()
    for kind in MESSAGES.values():
        section = page.partition(f"## {kind.__name__}\n")[2].partition("\n## ")[0]
        assert all(f"| `{name}` |" in section for name in kind.__dataclass_fields__), kind
    assert all(f"| `{name}` |" in page for name in OPERATIONS)


def test_every_page_is_in_the_manuals_list_once() -> None:
    def names(part: Any) -> list[str]:
        if isinstance(part, str):
            return [part]
        return [name for one in (part.values() if isinstance(part, dict) else part) for name in names(one)]

    listed = names(yaml.safe_load((ROOT / "mkdocs.yml").read_text("utf-8"))["nav"])
    assert sorted(listed) == sorted([*PAGES_BY_HAND, *PAGES])
    assert not set(PAGES_BY_HAND) & set(PAGES)


def test_readme_is_short() -> None:
    assert len((ROOT / "README.md").read_text("utf-8").splitlines()) <= 120


def test_what_runs_before_a_commit_or_a_push_is_what_ci_runs() -> None:
    lines = (ROOT / ".ci" / "run").read_text("utf-8").splitlines()
    checks = [line for line in lines if line.startswith(("./echelon", ".venv/bin/"))]
    hooks = yaml.safe_load((ROOT / ".pre-commit-config.yaml").read_text("utf-8"))["repos"][0]["hooks"]
    assert {hook["entry"] for hook in hooks} == set(checks)
    assert len(checks) == 5
