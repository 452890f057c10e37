"""One trial: a scenario, overrides, a seed, and what is measured of it, all as data."""

import hashlib
import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from typing import Any

from experiments.trials.code_version import check_code_version, code_version
from experiments.trials.measures import Event
from formation.loading.source import LOADED, Kind, Source
from formation.scenario import files
from formation.scenario.overrides import Overrides, merged
from formation.scenario.scenario import Scenario

Label = bool | int | float | str
"""One value of an axis, as it stands in a table."""
SERIES_INTERVAL = 0.1
"""Between the samples of the level that are kept [s]."""
GAP_EVERY = 10
"""Ticks from one sample of the Nash gap to the next: 10 Hz at the paper's control interval."""


@dataclass(frozen=True, slots=True)
class Measurement:
    """What is measured of a trial, and what else is kept of it."""

    measures: tuple[str, ...] = ()
    """Names in MEASURES (experiments/trials/measures.py)."""
    warmup: float = 0.0
    """Measures start at this simulated time [s]."""
    event: Event | None = None
    """What upsets the formation, if anything does."""
    series: bool = False
    """Keep the level over time."""
    signals: bool = False
    """Keep poses, inputs and errors of every tick."""
    gap: bool = False
    """Sample the Nash gap; needs `signals`."""


@dataclass(frozen=True, slots=True)
class Trial:
    """One simulation, complete: it needs no file of the machine that runs it."""

    name: str
    """What reports and errors call it."""
    scenario: Mapping[str, Any]
    """The keys that the scenario's file and the overrides set, as nested data; the seed is apart."""
    seed: int
    """Of noise and faults."""
    measurement: Measurement
    cost: int
    """Control intervals times robots: how long it takes, by and large."""
    labels: Mapping[str, Label] = field(default_factory=dict)
    """Its point in a grid, by column: the scenario and every axis."""
    code: str = field(default_factory=code_version)
    """`code_version()` of who asks."""
    user_code: tuple[Source, ...] = ()
    """Code of users' own that it needs, with the text."""

    @property
    def key(self) -> str:
        """Names the result: the same scenario, measured the same way by the same code."""
        event = self.measurement.event
        measurement = {**asdict(self.measurement), "event": event and event.model_dump()}
        named = [self.scenario, self.seed, measurement, self.code, *(source.sha256 for source in self.user_code)]
        return hashlib.sha256(json.dumps(named, sort_keys=True).encode()).hexdigest()

    def load(self) -> Scenario:
        """The scenario that is simulated. Raises ScenarioError."""
        return files.parse(self.scenario, {"seed": self.seed}, where=self.name)

    def run(self) -> dict[str, Any]:
        """Simulate and measure, in this process; the result as plain data (experiments/trials/result.py).

        Raises:
            EchelonError: the scenario is wrong, or this machine has other code than who asks.
        """
        from experiments.trials.simulate import simulate  # noqa: PLC0415  loads the kernels: only workers need them
        from runtime.user_code import admit  # noqa: PLC0415

        check_code_version(self.code)
        for source in self.user_code:
            admit(source)
        return simulate(self).plain()


def trial(
    name: str, scenario: str, overrides: Overrides, seed: int, measurement: Measurement, *, limit: float | None = None
) -> Trial:
    """A trial of a scenario by its name or file.

    Args:
        name: what reports and errors call it.
        scenario: which scenario.
        overrides: what differs from it, as nested data.
        seed: of noise and faults.
        measurement: what is kept.
        limit: where a longer scenario is cut [s].

    Raises:
        ScenarioError: the scenario does not exist or is wrong; one line per mistake.
    """
    loaded = files.load(scenario, overrides)
    if limit is not None and limit < loaded.duration:
        loaded = files.load(scenario, merged(overrides, {"duration": limit}))
    # A fault tells which keys it changes by setting them: what is not set stays out.
    table = loaded.model_dump(mode="json", exclude_unset=True)
    return Trial(name, table, seed, measurement, loaded.ticks * loaded.size, user_code=_user_code(loaded))


def _user_code(scenario: Scenario) -> tuple[Source, ...]:
    """What of the scenario is loaded code of a user's own."""
    names: list[tuple[Kind, str]] = [
        ("controller", scenario.controller.name),
        ("bodies", scenario.bodies.implementation),
    ]
    return tuple(source for key in names if (source := LOADED.get(key)) is not None)
