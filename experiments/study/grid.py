"""From a study to its trials: every point of the grid with every seed."""

import itertools
from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path

from experiments.study.study import Study, Value
from experiments.trials.trial import Measurement, Trial, trial
from formation.errors import ScenarioError, StudyError
from formation.scenario.overrides import Overrides, merged


def points(study: Study) -> Iterator[tuple[dict[str, Value], str, Overrides]]:
    """Every point of the grid, seeds apart, in grid order: its labels, its scenario (name or file), its overrides."""
    for name in study.scenarios:
        for labels in itertools.product(*(axis.labels for axis in study.axes)):
            chosen = list(zip(study.axes, labels, strict=True))
            point: dict[str, Value] = dict(
                (("scenario", Path(name).stem), *((axis.name, label) for axis, label in chosen))
            )
            yield point, name, merged(study.overrides, *(axis.overrides(label) for axis, label in chosen))


def trials(study: Study) -> list[Trial]:
    """All trials, in the order of the table: the last axis and then the seed change fastest.

    Raises:
        StudyError: points of the grid that cannot be simulated; one line per mistake.
    """
    measurement = Measurement(tuple(study.measures), study.warmup, study.event, series=study.keeps_series)
    found: list[Trial] = []
    wrong: dict[str, str] = {}  # a mistake, and the first point of the grid that has it
    for point, scenario, overrides in points(study):
        name = describe(point)
        try:
            first = trial(name, scenario, overrides, 0, measurement)
        except ScenarioError as error:
            for line in str(error).splitlines():
                wrong.setdefault(line, name)
            continue
        duration = first.load().duration
        if study.warmup >= duration:
            wrong.setdefault(f"warmup: expected less than {duration:g} s; got {study.warmup:g}", name)
        if study.event and study.event.until >= duration:
            wrong.setdefault(f"event.until: expected less than {duration:g} s; got {study.event.until:g}", name)
        found += [replace(first, name=f"{name}, seed {seed}", seed=seed, labels=point) for seed in range(study.seeds)]
    if wrong:
        raise StudyError("\n".join(f"{study.name}: {line} (at {where})" for line, where in wrong.items()))
    return found


def describe(point: Mapping[str, Value]) -> str:
    """A point of the grid as errors name it: "triangle-circle, latency 0.5"."""
    return ", ".join(str(label) if column == "scenario" else f"{column} {label}" for column, label in point.items())
