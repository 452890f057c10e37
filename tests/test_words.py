"""One word for one thing (docs/design.md, section 6): robots drive, an episode is simulated; only messages fly."""

import re
from pathlib import Path

import pytest

from tests.test_architecture import ROOMS

ROOT = Path(__file__).parent.parent
FLYING = re.compile(r"\b(?:fly|flies|flew|flying|flown|flights?)\b", re.IGNORECASE)
MESSAGES = re.compile(r"\bin flight\b", re.IGNORECASE)
MIND = re.compile(r"\bminds?\b", re.IGNORECASE)
TEXTS = {".py", ".toml", ".html", ".j2", ".css", ".js"}


def texts() -> list[Path]:
    """Every text of the product, and what is written about it."""
    found = [file for room in (*ROOMS, "scenarios", "studies") for file in (ROOT / room).rglob("*.*")]
    found = [file for file in found if file.suffix in TEXTS]
    return [*found, ROOT / "echelon", ROOT / "README.md", *(ROOT / "docs").glob("*.md")]


@pytest.mark.parametrize("word", [FLYING, MIND], ids=["fly", "mind"])
def test_a_word_that_is_not_the_fields_is_not_used(word: re.Pattern[str]) -> None:
    files = texts()
    assert len(files) > 100
    wrong = [
        f"{file.relative_to(ROOT)}:{number}: {line.strip()}"
        for file in files
        for number, line in enumerate(file.read_text("utf-8").splitlines(), 1)
        if word.search(MESSAGES.sub("", line))
    ]
    assert not wrong


def test_what_is_looked_for_is_found() -> None:
    assert FLYING.search("Fly the scenario")
    assert FLYING.search("what is flown")
    assert not FLYING.search("counts.in_flight")
    assert not FLYING.search(MESSAGES.sub("", "what messages in flight promised"))
    assert MIND.search("a robot's mind")
