"""Study files: a grid of trials, what is measured of them, and how it is shown (`studies/*.toml`)."""

from collections.abc import Iterable
from pathlib import Path as File
from typing import Annotated, Any, Literal

from pydantic import Field, FiniteFloat, StrictBool, StrictInt, ValidationError, model_validator

from experiments.trials.measures import MEASURES, Event
from formation.errors import ScenarioError, StudyError, unknown
from formation.scenario.files import is_file, table_of
from formation.scenario.overrides import Overrides, at_path, merged, paths
from formation.schema import Duration, Model
from formation.validation import COLUMN, LABEL, problems

Value = StrictBool | StrictInt | FiniteFloat | str
"""One value of an axis, as it stands in the table."""
Name = Annotated[str, Field(pattern=COLUMN)]

RESERVED = ("trial", "scenario", "seed", "trajectory_sha256", *MEASURES)
"""Columns that every table has, or may have, besides the axes."""
MAX_TRIALS = 1_000_000


class Axis(Model):
    """One dimension of the grid and one column of the table: a key's values, or named choices of overrides."""

    name: Name
    """Of the column."""
    unit: str = ""
    """For the axis of a figure."""
    key: Annotated[str, Field(min_length=1)] | None = None
    """The scenario's key that takes the values, such as link.latency."""
    values: Annotated[list[Value], Field(min_length=1)] | None = None
    """What the key takes, one after the other."""
    choices: Annotated[dict[str, dict[str, Any]], Field(min_length=1)] | None = None
    """What each name stands for: overrides such as { controller.age_plans = false }."""

    @model_validator(mode="after")
    def _one_way(self) -> "Axis":
        if self.name in RESERVED:
            raise ValueError(f"expected another name than {self.name}: the table has such a column already")
        if (self.choices is None) == (self.key is None) or (self.key is None) != (self.values is None):
            raise ValueError("expected either key and values, or choices")
        if len({str(value) for value in self.labels}) != len(self.labels):
            raise ValueError("expected values that differ from each other")
        return self

    @property
    def labels(self) -> list[Value]:
        """The values of its column, in the order of the grid."""
        return list(self.values or ()) if self.choices is None else list(self.choices)

    @property
    def numeric(self) -> bool:
        """Whether the labels are numbers, and a figure may draw a line over them."""
        return all(isinstance(label, int | float) and not isinstance(label, bool) for label in self.labels)

    def overrides(self, label: Value) -> Overrides:
        """What a label stands for."""
        return at_path(str(self.key), label) if self.choices is None else self.choices[str(label)]

    def set_keys(self) -> set[str]:
        """Paths of the scenario's keys that this axis sets."""
        return {path for label in self.labels for path in paths(self.overrides(label))}


class FigureSpec(Model):
    """One figure of the study, drawn from its table."""

    name: Name
    """Of its files."""
    kind: Literal["bands", "surface", "recovery"]
    """bands: a line over x with the interval over seeds; surface: the mean over x and y as a map; recovery: the level
    over time, with the event."""
    title: str = ""
    """Above it."""
    value: str | None = None
    """The measure that is drawn (bands, surface)."""
    x: str | None = None
    """The axis along the bottom (bands, surface)."""
    y: str | None = None
    """The axis up the side (surface)."""
    by: str | None = None
    """The axis whose labels become lines (bands, recovery)."""
    panels: str | None = None
    """The axis whose labels become panels side by side."""
    ratio: bool = False
    """Draw the paired ratio to the baseline instead of the measure."""
    only: dict[str, list[Value]] = Field(default_factory=dict)
    """Labels of an axis that are drawn; all of them, if absent."""
    log: bool = True
    """Logarithmic value."""
    log_x: bool = False
    """Logarithmic x."""


class Bound(Model):
    """What the study is expected to show."""

    where: dict[str, Value] = Field(default_factory=dict)
    """Labels of axes; every combination of the others has to keep the bound."""
    measure: str
    """Which figure of a trial is bounded."""
    statistic: Literal["mean", "median", "min", "max", "ratio"] = "mean"
    """Over the seeds; min, max: every trial. ratio: mean of the paired ratios to the baseline."""
    at_most: FiniteFloat | None = None
    """Or at least: one of both, in the measure's unit."""
    at_least: FiniteFloat | None = None
    """One of both, in the measure's unit."""
    why: str = ""
    """Where the bound comes from."""

    @model_validator(mode="after")
    def _one_way(self) -> "Bound":
        if (self.at_most is None) == (self.at_least is None):
            raise ValueError("expected either at_most or at_least")
        return self

    def excess(self, found: float) -> float:
        """By how much a figure breaks the bound; not above 0 if it holds."""
        if self.at_most is not None:
            return found - self.at_most
        assert self.at_least is not None
        return self.at_least - found


class Study(Model):
    """A grid over scenarios, axes and seeds; every point of it meets the same seeds, that is, the same chance."""

    name: Annotated[str, Field(pattern=LABEL)]
    """Of its folder of results."""
    title: str = ""
    """What it asks, in a sentence."""
    scenarios: Annotated[list[str], Field(min_length=1)]
    """Names, or TOML files (from the study's own folder)."""
    overrides: dict[str, Any] = Field(default_factory=dict)
    """What differs from the scenario in every trial, as the scenario's own tables."""
    axes: tuple[Axis, ...] = ()
    seeds: Annotated[int, Field(ge=1, le=MAX_TRIALS)] = 10
    """Seeds 0, 1, ... so many: every point of the grid meets all of them."""
    warmup: Duration = 0.0
    """Measures start at this simulated time [s]."""
    measures: Annotated[list[str], Field(min_length=1)]
    """What is measured of every trial; figures and bounds may name these."""
    event: Event | None = None
    baseline: dict[str, Value] = Field(default_factory=dict)
    """Labels of axes: every trial is compared with that of the same seed there."""
    figures: tuple[FigureSpec, ...] = ()
    bounds: tuple[Bound, ...] = ()

    @model_validator(mode="after")
    def _consistent(self) -> "Study":
        wrong = [*self._wrong_measures(), *self._wrong_axes(), *self._wrong_labels()]
        if wrong:
            raise ValueError("\n".join(wrong))
        return self

    def _wrong_measures(self) -> Iterable[str]:
        for index, name in enumerate(self.measures):
            if name not in MEASURES:
                yield unknown(f"measures[{index}]", name, MEASURES)
            elif MEASURES[name].of_event and self.event is None:
                yield f"measures[{index}]: expected an [event] for {name}; got none"
        if self.event and self.event.factor is not None and self.event.at <= self.warmup:
            yield f"event.at: expected more than the warmup of {self.warmup:g} s for factor; got {self.event.at:g}"
        used = [(f"figures[{index}].value", drawn.value) for index, drawn in enumerate(self.figures)]
        used += [(f"bounds[{index}].measure", bound.measure) for index, bound in enumerate(self.bounds)]
        for where, measure in used:
            if measure is not None and measure not in self.measures:
                yield unknown(where, measure, self.measures)

    def _wrong_axes(self) -> Iterable[str]:
        names = [axis.name for axis in self.axes]
        for index, name in enumerate(names):
            if name in names[:index]:
                yield f"axes[{index}].name: expected a name of its own; got {name!r} again"
        if self.trials > MAX_TRIALS:
            yield f"axes: expected at most {MAX_TRIALS} trials; got {self.trials}"
        for index, drawn in enumerate(self.figures):
            needed = {"bands": ("value", "x"), "surface": ("value", "x", "y"), "recovery": ()}[drawn.kind]
            for key in needed:
                if getattr(drawn, key) is None:
                    yield f"figures[{index}].{key}: expected a value for {drawn.kind}; got nothing"
            for key in ("x", "y", "by", "panels"):
                name = getattr(drawn, key)
                if name is not None and name not in ("scenario", *names):
                    yield unknown(f"figures[{index}].{key}", name, ["scenario", *names])
            if drawn.kind == "recovery" and self.event is None:
                yield f"figures[{index}].kind: expected an [event] for recovery; got none"
            if drawn.ratio and not self.baseline:
                yield f"figures[{index}].ratio: expected a [baseline]; got none"

    def _wrong_labels(self) -> Iterable[str]:
        tables: list[tuple[str, dict[str, list[Value]]]] = [("baseline", {k: [v] for k, v in self.baseline.items()})]
        tables += [(f"figures[{i}].only", drawn.only) for i, drawn in enumerate(self.figures)]
        tables += [(f"bounds[{i}].where", {k: [v] for k, v in b.where.items()}) for i, b in enumerate(self.bounds)]
        labels = self.labels
        for where, table in tables:
            for name, values in table.items():
                if name not in labels:
                    yield unknown(f"{where}.{name}: unknown axis", name, labels)
                    continue
                for value in values:
                    if value not in labels[name]:
                        yield unknown(f"{where}.{name}", str(value), map(str, labels[name]))
        for index, bound in enumerate(self.bounds):
            if bound.statistic == "ratio" and not self.baseline:
                yield f"bounds[{index}].statistic: expected a [baseline] for a ratio; got none"

    @property
    def labels(self) -> dict[str, list[Value]]:
        """What every column of the grid may say, `scenario` first, in the order of the grid."""
        scenarios: list[Value] = [File(name).stem for name in self.scenarios]
        return {"scenario": scenarios} | {axis.name: axis.labels for axis in self.axes}

    @property
    def trials(self) -> int:
        """Size of the grid."""
        count = len(self.scenarios) * self.seeds
        for axis in self.axes:
            count *= len(axis.labels)
        return count

    @property
    def keeps_series(self) -> bool:
        """Whether the level over time is kept of every trial."""
        return any(drawn.kind == "recovery" for drawn in self.figures)


SHIPPED = File(__file__).parents[2] / "studies"


def shipped() -> list[str]:
    """Names of the studies that come with the project."""
    return sorted(file.stem for file in SHIPPED.glob("*.toml"))


def load(name: str, *, seeds: int | None = None, overrides: Overrides | None = None) -> Study:
    """A study by its name or its TOML file.

    Args:
        name: which one.
        seeds: so many instead of its own number.
        overrides: put on top of the study's own; those of its axes cannot be replaced.

    Raises:
        StudyError: it does not exist or is wrong; one line per mistake.
    """
    if not is_file(name) and name not in shipped():
        raise StudyError(unknown("study", name, [*shipped(), "FILE.toml"]))
    file = File(name) if is_file(name) else SHIPPED / f"{name}.toml"
    try:
        raw = table_of(file, name)
    except ScenarioError as error:
        raise StudyError(str(error)) from None
    study = parse(raw, where=name)
    folder = file.parent.resolve() if file.is_file() else File.cwd()  # nothing lies beside a pipe
    scenarios = [str(folder / s) if is_file(s) else s for s in study.scenarios]
    for path in paths(overrides or {}):
        for axis in study.axes:
            if path in axis.set_keys():
                raise StudyError(f"--set {path}: expected a key that no axis sets; {axis.name} does")
    changes: dict[str, Any] = {"scenarios": scenarios, "overrides": merged(study.overrides, overrides or {})}
    return study.model_copy(update=changes | ({} if seeds is None else {"seeds": seeds}))


def parse(raw: dict[str, Any], *, where: str = "study") -> Study:
    """A study from its raw table.

    Raises:
        StudyError: one line per mistake.
    """
    if "settings" in raw:
        raise StudyError(f"{where}: settings: expected overrides, a table such as overrides = {{ duration = 60 }}")
    try:
        return Study.model_validate(raw)
    except ValidationError as error:
        lines = [line.removeprefix("file: ") for problem in problems(error, Study) for line in problem.split("\n")]
        raise StudyError("\n".join(f"{where}: {line}" for line in lines)) from None
