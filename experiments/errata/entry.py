"""One erratum in words, before anything is computed or simulated."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

from experiments.errata.evidence import Numbers

PROOF = "A proof or a statement; no controller computes with it."


@dataclass(frozen=True, slots=True)
class Entry:
    """One erratum before anything is computed or simulated."""

    number: int
    where: str
    printed: str
    mended: str
    test: str
    """The test that holds it, without the `test_` in front."""
    shows: str
    """A sentence with places {0}, {1} for the numbers."""
    numbers: Callable[[], Numbers]
    """Computes them."""
    cases: tuple[str, ...] = ()
    """Names in CASES (experiments/errata/errata.py), simulated as printed and with this one mended."""
    as_printed: Mapping[str, Any] = field(default_factory=dict)
    as_mended: Mapping[str, Any] = field(default_factory=dict)
    """Overrides of the scenario for the two."""
    note: str = ""
