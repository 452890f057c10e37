"""What a report is made of, and its Markdown; experiments/report/html.py makes the page of it.

Text may hold **bold**, `code` and [words](#anchor); everything else is taken literally.
"""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal

from matplotlib.figure import Figure

from experiments.report.table import Table

Outcome = Literal["holds", "holds in part", "does not hold", "not judged"]
MARKS: dict[Outcome, str] = {"holds": "✓", "holds in part": "◐", "does not hold": "✗", "not judged": "–"}


@dataclass(frozen=True, slots=True)
class Verdict:
    """A claim, what was found, and whether it holds; the outcome is computed from the same data as the words."""

    claim: str
    """A sentence: what is claimed, by whom."""
    found: str
    """A sentence with numbers."""
    outcome: Outcome


@dataclass(frozen=True, slots=True, eq=False)
class Picture:
    """A figure of the report."""

    stem: str
    """Of its files in `figures/`."""
    figure: Figure
    caption: str
    alt: str
    """What it shows, for those who cannot see it."""


Block = str | Table | Picture | Verdict


@dataclass(frozen=True, slots=True, eq=False)
class Section:
    """A heading and what stands below it."""

    anchor: str
    title: str
    blocks: tuple[Block, ...]
    level: int = 2

    def of(self, kind: type[Verdict]) -> list[Verdict]:
        """Its verdicts."""
        return [block for block in self.blocks if isinstance(block, kind)]


@dataclass(frozen=True, slots=True, eq=False)
class Report:
    """The whole of it."""

    title: str
    lead: tuple[str, ...]
    """Paragraphs before the first section."""
    sections: tuple[Section, ...]

    def tables(self) -> list[Table]:
        """In their order."""
        return [block for section in self.sections for block in section.blocks if isinstance(block, Table)]

    def pictures(self) -> list[Picture]:
        """In their order."""
        return [block for section in self.sections for block in section.blocks if isinstance(block, Picture)]

    def verdicts(self) -> list[tuple[Section, Verdict]]:
        """Every verdict with its section."""
        return [(section, verdict) for section in self.sections for verdict in section.of(Verdict)]


def unjudged(section: Section) -> Section:
    """The section without a judgement: for trials that are too short to tell."""
    blocks = (replace(block, outcome="not judged") if isinstance(block, Verdict) else block for block in section.blocks)
    return replace(section, blocks=tuple(blocks))


def grade(parts: list[bool]) -> Outcome:
    """`holds` if all parts are true, `does not hold` if none is, else `holds in part`."""
    if not parts:
        raise ValueError("a verdict needs at least one part")
    if all(parts):
        return "holds"
    return "holds in part" if any(parts) else "does not hold"


def markdown(report: Report, figures: Path = Path("figures")) -> str:
    """The report as Markdown that refers to the PNG files in `figures`."""
    parts = [f"# {report.title}", *report.lead, "## Contents"]
    parts.append("\n".join(f"{'  ' * (s.level - 2)}- [{s.title}](#{s.anchor})" for s in report.sections))
    for section in report.sections:
        parts.append(f'<a id="{section.anchor}"></a>\n\n{"#" * section.level} {section.title}')
        parts += [_block(block, figures) for block in section.blocks]
    return "\n\n".join(parts) + "\n"


def _block(block: Block, figures: Path) -> str:
    match block:
        case str():
            return block
        case Table():
            return f"**{block.caption}**\n\n{block.markdown()}"
        case Picture():
            return f"![{block.alt}]({(figures / f'{block.stem}.png').as_posix()})\n\n*{block.caption}*"
        case Verdict():
            return f"> **{MARKS[block.outcome]} {block.outcome}**\n>\n> Claim: {block.claim}\n>\n> Found: {block.found}"
