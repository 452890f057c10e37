"""What a chapter of the report is: flights it wants, and sections it makes of them."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from experiments.report.report import Section
from experiments.trials.trial import Trial, TrialResult
from formation.scenario.registry import NAMES

ALL_CONTROLLERS = ("leader_follower", "virtual_structure", "consensus", "paper", "nash", "centralised")
"""In the order of tables and figures; the report shows those that there are."""


@dataclass(frozen=True, slots=True)
class Extent:
    """How much is flown."""

    seed: int = 0
    """The first seed."""
    seeds: int = 2
    """Flights with noise per condition."""
    limit: float | None = None
    """Where every flight is cut [s]; for a quick look."""

    def order(
        self, key: str, scenario: str, *settings: str, in_formation: bool = False, gap: bool = False, seed: int = 0
    ) -> Trial:
        """A flight of this extent; `seed` counts from the first."""
        changes = (*settings, f"seed={self.seed + seed}")
        return Trial(key, scenario, changes, in_formation=in_formation, gap=gap, limit=self.limit)

    @property
    def note(self) -> str:
        """What figures say of it."""
        return f"seed {self.seed}" + ("" if self.limit is None else f", flights cut at {self.limit:g} s")


@dataclass(frozen=True, slots=True)
class Chapter:
    """A part of the report."""

    orders: Callable[[Extent], Sequence[Trial]]
    """What it wants flown."""
    sections: Callable[[Extent, Mapping[str, TrialResult]], Sequence[Section]]
    """What it says of its flights; called within `style.styled()`."""


def controllers(wanted: Sequence[str] = ALL_CONTROLLERS) -> list[str]:
    """Those of `wanted` that this version has, in the order of tables."""
    return [name for name in ALL_CONTROLLERS if name in wanted and name in NAMES]
