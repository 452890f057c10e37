"""`echelon paper`: every result of the paper's section 4 again, and what this project adds, as one report."""

import os
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

from experiments.paper import errata_chapter, nash_gap, noisy, replication, stuck, switching
from experiments.paper.chapters import Chapter, Extent
from experiments.report.html import html
from experiments.report.report import Report, Section, Verdict, markdown, unjudged
from experiments.report.style import release, save, styled
from experiments.report.table import Table
from experiments.trials.trial import TrialResult, WorkerPool, simulate_all
from formation.errors import EchelonError

CHAPTERS: tuple[Chapter, ...] = (replication.CHAPTER, nash_gap.CHAPTER, stuck.CHAPTER, noisy.CHAPTER, switching.CHAPTER)
TITLE = "Nash equilibrium-based geometric pattern formation: the paper again, in numbers"
Progress = Callable[[str, int, int], None]
"""Told what is being done, how much of it is done, and of how much."""


def folder(name: str) -> Path:
    """The folder of that name, made if it is not there, in which a report can be written.

    Raises:
        EchelonError: it cannot be made or written to.
    """
    place = Path(name)
    if not place.exists() and not place.absolute().parent.is_dir():
        raise EchelonError(f"--out: expected a folder, or a new one in a folder that exists; got {name}")
    try:
        for path in (place, place / "figures", place / "tables"):
            path.mkdir(exist_ok=True)
        writable = all(os.access(path, os.W_OK | os.X_OK) for path in (place, place / "figures", place / "tables"))
    except OSError as error:
        raise EchelonError(f"--out: expected a folder that can be written to; got {name} ({error.strerror})") from None
    if not writable:
        raise EchelonError(f"--out: expected a folder that can be written to; got {name} (permission denied)")
    return place


def write(out: Path, extent: Extent, progress: Progress, workers: int | None = None) -> Report:
    """Fly everything and write the report.

    Args:
        out: an existing folder; in it come report.html, report.md, figures/ and tables/.
        extent: how much is flown.
        progress: told how far it is.
        workers: processes to fly in; by default one per core.
    """
    orders = [order for chapter in CHAPTERS for order in chapter.orders(extent)]
    with WorkerPool(workers) as crew:
        flown = simulate_all(orders, crew, lambda done, of: progress("flights", done, of))
        errata = errata_chapter.simulate(extent, crew, lambda done, of: progress("errata", done, of))
        readings = errata_chapter.read(extent, crew, lambda done, of: progress("readings", done, of))
    with styled():
        report = compose(extent, flown, errata_chapter.sections(errata, readings))
        pictures = report.pictures()
        for done, picture in enumerate(pictures):
            progress("figures", done, len(pictures))
            save(picture.figure, out / "figures" / picture.stem, extent.note)
        progress("figures", len(pictures), len(pictures))
    for table in report.tables():
        _text(out / "tables" / f"{table.name}.csv", table.csv())
    _text(out / "report.md", markdown(report))
    _text(out / "report.html", html(report, lambda picture: (out / "figures" / f"{picture.stem}.svg").read_bytes()))
    return report


def compose(extent: Extent, flown: Mapping[str, TrialResult], more: Sequence[Section]) -> Report:
    """The report of what was flown, and more sections; called within `style.styled()`."""
    sections = [section for chapter in CHAPTERS for section in chapter.sections(extent, flown)]
    sections += more
    if extent.limit is not None:
        sections = [unjudged(section) for section in sections]
    cut = (
        ""
        if extent.limit is None
        else (f" **Every flight was cut at {extent.limit:g} s: too short to judge a claim.**")
    )
    lead = (
        "Lee, Kim, Lee and Myung (2014) let wheeled robots keep a formation by a receding-horizon Nash game between "
        "neighbours, and show it in eleven figures without a number. Here each of their tests is flown again: by "
        "`paper`, the algorithm as printed; by `leader_follower`, the law that they compare with; and by `nash`, this "
        "project's controller. Numbers of equations and figures are the paper's.",
        "Beside each figure stands what is claimed, what was found, and whether it holds. The verdicts are computed "
        "from the flights: “very small” and “much smaller” mean a fifth at most, “small” a tenth of the spacing, "
        "“zero” a hundredth. The distance error is lₑ = lᵣ − l of a robot and its upstream neighbour, the angle error "
        "ψₑ = ψᵣ − ψ (section 2.1).",
        f"Echelon {release()}, {len(flown)} flights, seed {extent.seed}. The same seed gives the same bytes.{cut}",
    )
    return Report(TITLE, lead, (*sections, _files(sections)))


def _files(sections: list[Section]) -> Section:
    names = [block.name for section in sections for block in section.blocks if isinstance(block, Table)]
    return Section(
        "files",
        "Files",
        (
            "Beside this report: `figures/` has every figure as PNG and SVG; `tables/` has every table as CSV with "
            f"nine significant digits ({', '.join(f'`{name}`' for name in names)}). "
            "`echelon paper --json` prints them.",
        ),
    )


def as_json(report: Report) -> dict[str, object]:
    """The tables and verdicts of the report, for `--json`."""
    return {
        "version": release(),
        "tables": {table.name: table.json() for table in report.tables()},
        "verdicts": [_verdict(section, verdict) for section, verdict in report.verdicts()],
    }


def _verdict(section: Section, verdict: Verdict) -> dict[str, str]:
    return {
        "section": section.anchor,
        "claim": verdict.claim,
        "found": verdict.found,
        "outcome": verdict.outcome,
    }


def _text(file: Path, text: str) -> None:
    file.write_text(text, encoding="utf-8", newline="\n")
