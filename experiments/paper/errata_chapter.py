"""The report's page of errata, and what other readings of the third test's text would mean."""

from collections.abc import Sequence

from experiments.errata.errata import Erratum
from experiments.errata.readings import BOUND, LOOK, Reading
from experiments.report.report import Section, Verdict, grade
from experiments.report.table import Cell, Table


def sections(errata: Sequence[Erratum], readings: Sequence[Reading]) -> list[Section]:
    """The page, and the readings if there are any."""
    page = Section(
        "errata",
        "Errata of the paper",
        (
            f"{len(errata)} places where the printed text contradicts itself, its own figures, or a derivation. Each "
            "was found by computing; the test named with its evidence fails on the printed form and passes on the "
            "mended one.",
            Table(
                "errata",
                "Printed and mended",
                ("no.", "where", "printed", "mended", "evidence", "note"),
                tuple((e.number, e.where, e.printed, e.mended, e.evidence, e.note) for e in errata),
            ),
            "What each of them does when it is the only one that is mended, every other as printed. A change for the "
            "worse is no argument for the printed form: two errors can hide each other.",
            effects(errata),
        ),
    )
    if not readings:
        return [page]
    words = (
        "The third test's text leaves room: it prints no ψᵣ, four entries of Q for five states, and a procedure with "
        "gaps. Each reading below is simulated for a lap from the printed start; it counts as bounded if the RMS of lₑ "
        f"stays below {BOUND:g} mm, the largest error of the start, in every 10 s. The spectral radius is that of the "
        f"closed loop over one second, linearised about the state after {LOOK:g} s: above 1 no start stays."
    )
    return [
        page,
        Section(
            "third-test-readings",
            "The third test, read in every way",
            (words, readings_table(readings), bounded(readings)),
        ),
    ]


def effects(errata: Sequence[Erratum]) -> Table:
    """A row for each erratum and case that it affects."""
    rows: list[tuple[Cell, ...]] = []
    for erratum in errata:
        for case, (printed, mended) in (erratum.effect_mm or {}).items():
            rows.append((erratum.number, case, printed, mended, mended - printed))
    return Table(
        "errata-effects",
        "RMS of lₑ, worst robot [mm]",
        ("no.", "case", "as printed", "only this one mended", "change"),
        tuple(rows),
    )


def readings_table(readings: Sequence[Reading]) -> Table:
    """A row for each reading."""
    heads = ("reading", "what it means", "first 10 s mm", "worst 10 s mm", "last 10 s mm", "spectral radius", "bounded")
    return Table(
        "third-test-readings",
        "RMS of lₑ of the three robots",
        heads,
        tuple(
            (r.name, r.words, r.rms_mm[0], max(r.rms_mm), r.rms_mm[-1], r.spectral_radius, r.bounded) for r in readings
        ),
    )


def bounded(readings: Sequence[Reading]) -> Verdict:
    """Fig. 11: whether some reading of the printed text stays bounded."""
    kept = [reading.name for reading in readings if reading.bounded]
    return Verdict(
        "The printed text describes a controller that keeps the triangle on the circle (fig. 11).",
        f"{len(kept)} of {len(readings)} readings stay bounded{': ' if kept else ''}{'; '.join(kept)}.",
        grade([reading.bounded for reading in readings]),
    )
