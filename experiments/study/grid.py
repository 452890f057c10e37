"""From a study to its flights: every point of the grid with every seed, each a value that can be sent anywhere."""

import hashlib
import itertools
import json
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from importlib.metadata import version
from pathlib import Path

from experiments.study.study import Study, Value
from formation.errors import ScenarioError, StudyError
from formation.scenario import files

ROOT = Path(__file__).parents[2]
DECIDES = ("formation", "network", "agents", "world", "runtime/inprocess.py", "experiments/study/flights.py")
DECIDES_TOO = ("experiments/study/outcomes.py",)
"""What a row of the table depends on, besides the study."""


@dataclass(frozen=True, slots=True)
class Job:
    """One flight of a study, complete: it needs no file of the machine that flies it."""

    index: int
    """Its place in the grid and its row in the table."""
    cell: tuple[tuple[str, Value], ...]
    """Column and label: the scenario and every axis."""
    seed: int
    scenario: str
    """JSON of what is flown, with the seed."""
    measuring: str
    """JSON of what is measured (experiments/study/flights.py)."""
    code: str
    """`code_version()` of who asks."""
    cost: int
    """Control intervals times robots: how long it takes, by and large."""

    @property
    def key(self) -> str:
        """Names the result: the same flight, measured the same way by the same code."""
        return hashlib.sha256("\n".join([self.scenario, self.measuring, self.code]).encode()).hexdigest()


@cache
def code_version() -> str:
    """The version of numpy and numba and a digest of the sources that decide a flight and its measures."""
    digest = hashlib.sha256(f"{version('numpy')} {version('numba')}".encode())
    for place in (*DECIDES, *DECIDES_TOO):
        at = ROOT / place
        for file in [at] if at.is_file() else sorted(at.rglob("*.py")):
            digest.update(file.relative_to(ROOT).as_posix().encode() + b"\0" + file.read_bytes())
    return digest.hexdigest()[:16]


def cells(study: Study) -> Iterator[tuple[tuple[tuple[str, Value], ...], str, list[str]]]:
    """Every point of the grid, seeds apart, in grid order: its labels, its scenario (name or file), its settings."""
    for name in study.scenarios:
        for labels in itertools.product(*(axis.labels for axis in study.axes)):
            chosen = list(zip(study.axes, labels, strict=True))
            cell = (("scenario", Path(name).stem), *((axis.name, label) for axis, label in chosen))
            yield cell, name, [*study.settings, *(s for axis, label in chosen for s in axis.settings(label))]


def jobs(study: Study) -> list[Job]:
    """All flights, in the order of the table: the last axis and then the seed change fastest.

    Raises:
        StudyError: points of the grid that cannot be flown; one line per mistake.
    """
    measuring = json.dumps(
        {
            "warmup": study.warmup,
            "measures": study.measures,
            "event": study.event and study.event.model_dump(),
            "series": study.keeps_series,
        },
        sort_keys=True,
    )
    found: list[Job] = []
    wrong: dict[str, str] = {}  # a mistake, and the first point of the grid that has it
    for cell, name, settings in cells(study):
        try:
            flown = files.load(name, settings)
        except ScenarioError as error:
            for line in str(error).splitlines():
                wrong.setdefault(line, words(cell))
            continue
        if study.warmup >= flown.duration:
            wrong.setdefault(f"warmup: expected less than {flown.duration:g} s; got {study.warmup:g}", words(cell))
        if study.event and study.event.until >= flown.duration:
            line = f"event.until: expected less than {flown.duration:g} s; got {study.event.until:g}"
            wrong.setdefault(line, words(cell))
        for seed in range(study.seeds):
            seeded = flown.model_copy(update={"seed": seed})
            job = Job(
                index=len(found),
                cell=cell,
                seed=seed,
                scenario=seeded.model_dump_json(exclude_unset=True),  # a fault says which keys it sets by setting them
                measuring=measuring,
                code=code_version(),
                cost=flown.ticks * flown.size,
            )
            found.append(job)
    if wrong:
        raise StudyError("\n".join(f"{study.name}: {line} (at {where})" for line, where in wrong.items()))
    return found


def words(cell: tuple[tuple[str, Value], ...]) -> str:
    """A point of the grid in words: "triangle-circle, latency 0.5"."""
    return ", ".join(str(label) if column == "scenario" else f"{column} {label}" for column, label in cell)
