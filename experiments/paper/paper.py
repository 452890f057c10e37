"""`echelon paper`: every result of the paper's section 4 again, and what this project adds, as one report."""

import math
import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from experiments.errata import errata, readings
from experiments.errata.errata import Erratum
from experiments.errata.readings import Reading
from experiments.paper import errata_chapter, nash_gap, noisy, replication, stuck, switching, talking
from experiments.paper.chapters import Chapter, Extent
from experiments.report.html import html
from experiments.report.report import Report, Section, Verdict, markdown, unjudged
from experiments.report.style import release, save, styled
from experiments.report.table import Table
from experiments.trials.batch import Place, run_batch
from experiments.trials.pool import Progress, Work
from experiments.trials.result import Signals, result_of
from formation.errors import EchelonError

CHAPTERS: tuple[Chapter, ...] = (
    replication.CHAPTER,
    nash_gap.CHAPTER,
    stuck.CHAPTER,
    noisy.CHAPTER,
    talking.CHAPTER,
    switching.CHAPTER,
)
TITLE = "Nash equilibrium-based geometric pattern formation: the paper again, in numbers"


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


def write(
    extent: Extent, place: Place, *, tell: Callable[[str], None], trials: Progress, figures: Callable[[int, int], None]
) -> Report:
    """Simulate what the folder's journal lacks, and write the report.

    Args:
        extent: how much is simulated.
        place: where, and an existing folder; in it come report.html, report.md, figures/ and tables/.
        tell: called with lines for the user.
        trials: called for each trial whose result is there.
        figures: called with the number of figures that are drawn, and of all.

    Raises:
        EchelonError: a trial failed.
    """
    out = place.folder
    results = _results(extent, place, tell, trials)
    with styled():
        report = compose(extent, results)
        pictures = report.pictures()
        for done, picture in enumerate(pictures):
            figures(done, len(pictures))
            save(picture.figure, out / "figures" / picture.stem, extent.note)
        figures(len(pictures), len(pictures))
    for table in report.tables():
        _text(out / "tables" / f"{table.name}.csv", table.csv())
    _text(out / "report.md", markdown(report))
    _text(out / "report.html", html(report, lambda picture: (out / "figures" / f"{picture.stem}.svg").read_bytes()))
    return report


@dataclass(frozen=True, slots=True, eq=False)
class Results:
    """What the report is made of."""

    signals: Mapping[str, Signals]
    """Of the chapters' trials, by name."""
    errata: Sequence[Erratum]
    readings: Sequence[Reading]
    """Of the third test; none in a quick look."""


def _results(extent: Extent, place: Place, tell: Callable[[str], None], progress: Progress) -> Results:
    """Everything that is simulated, in one batch. A quick look simulates no errata and no readings."""
    chapters = [trial for chapter in CHAPTERS for trial in chapter.trials(extent)]
    effects = errata.trials()
    laps = readings.quick() if extent.limit is None else ()
    batch: list[Work] = [*chapters, *(effects if extent.limit is None else ()), *laps]
    if len({work.name for work in batch}) != len(batch):
        raise ValueError("two trials have the same name")
    plain = {
        work.name: data for work, data in zip(batch, run_batch(batch, place, tell=tell, progress=progress), strict=True)
    }
    signals = {trial.name: result_of(trial, plain[trial.name]).signals for trial in chapters}
    rms_mm = {
        trial.name: 1e3 * plain[trial.name]["values"][errata.MEASURE] if extent.limit is None else math.nan
        for trial in effects
    }
    return Results(
        {name: found for name, found in signals.items() if found is not None},
        errata.errata_table(rms_mm),
        [readings.reading_of(lap, plain[lap.name]) for lap in laps],
    )


def compose(extent: Extent, results: Results) -> Report:
    """The report of these results; called within `style.styled()`."""
    sections = [section for chapter in CHAPTERS for section in chapter.sections(extent, results.signals)]
    sections += errata_chapter.sections(results.errata, results.readings)
    if extent.limit is not None:
        sections = [unjudged(section) for section in sections]
    cut = (
        "" if extent.limit is None else (f" **Every trial was cut at {extent.limit:g} s: too short to judge a claim.**")
    )
    lead = (
        "Lee, Kim, Lee and Myung (2014) let wheeled robots keep a formation by a receding-horizon Nash game between "
        "neighbours, and show it in eleven figures without a number. Here each of their tests is simulated again: by "
        "`paper`, the algorithm as printed; by `leader_follower`, the law that they compare with; and by `nash`, this "
        "project's controller. Numbers of equations and figures are the paper's.",
        "Beside each figure stands what is claimed, what was found, and whether it holds. The verdicts are computed "
        "from the trials: “very small” and “much smaller” mean a fifth at most, “small” a tenth of the spacing, "
        "“zero” a hundredth. The distance error is lₑ = lᵣ − l of a robot and its upstream neighbour, the angle error "
        "ψₑ = ψᵣ − ψ (section 2.1).",
        f"Echelon {release()}, {len(results.signals)} trials, seed {extent.seed}. "
        f"The same seed gives the same bytes.{cut}",
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
