"""What a chapter of the report is: trials it wants, and sections it makes of them."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from experiments.report.report import Section
from experiments.trials.result import Signals
from experiments.trials.trial import Measurement, Trial, trial
from formation.scenario.overrides import Overrides, merged
from formation.scenario.registry import BUILT_IN

ALL_CONTROLLERS = ("leader_follower", "virtual_structure", "consensus", "paper", "nash", "centralised")
"""In the order of tables and figures; the report shows those that there are."""
IN_FORMATION: Overrides = {"robots": {"poses": None}}
"""Start in formation, whatever start poses the scenario has."""


@dataclass(frozen=True, slots=True)
class Extent:
    """How much is simulated."""

    seed: int = 0
    """The first seed."""
    seeds: int = 2
    """Trials with noise per condition."""
    limit: float | None = None
    """Where every trial is cut [s]; for a quick look."""

    def trial(self, name: str, scenario: str, *overrides: Overrides, gap: bool = False, seed: int = 0) -> Trial:
        """A trial of this extent; `seed` counts from the first."""
        measurement = Measurement(signals=True, gap=gap)
        return trial(name, scenario, merged(*overrides), self.seed + seed, measurement, limit=self.limit)

    @property
    def note(self) -> str:
        """The extent in the footers of figures."""
        return f"seed {self.seed}" + ("" if self.limit is None else f", trials cut at {self.limit:g} s")


@dataclass(frozen=True, slots=True)
class Chapter:
    """A part of the report."""

    trials: Callable[[Extent], Sequence[Trial]]
    """What it wants simulated."""
    sections: Callable[[Extent, Mapping[str, Signals]], Sequence[Section]]
    """What it makes of the trials' signals, by name; called within `style.styled()`."""


def controllers(wanted: Sequence[str] = ALL_CONTROLLERS) -> list[str]:
    """Those of `wanted` that this version has, in the order of tables."""
    return [name for name in ALL_CONTROLLERS if name in wanted and name in BUILT_IN]


def controller(name: str) -> Overrides:
    """The override that chooses a controller."""
    return {"controller": {"name": name}}
