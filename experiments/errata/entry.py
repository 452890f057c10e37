"""One erratum in words, before anything is computed or flown."""

from collections.abc import Callable
from dataclasses import dataclass

from experiments.errata.evidence import Figures

PROOF = "A proof or a statement; no controller computes with it."


@dataclass(frozen=True, slots=True)
class Entry:
    """One erratum before anything is computed or flown."""

    number: int
    where: str
    printed: str
    mended: str
    test: str
    """The test that holds it, without the `test_` in front."""
    shows: str
    """A sentence with places {0}, {1} for the figures."""
    figures: Callable[[], Figures]
    flights: tuple[str, ...] = ()
    """Flights (experiments/errata/errata.py) that are flown as printed and with this one mended."""
    as_printed: tuple[str, ...] = ()
    as_mended: tuple[str, ...] = ()
    """Settings of the scenario for the two."""
    note: str = ""
