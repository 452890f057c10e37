"""One flight of a study, wherever it is flown: a pure function from a job to the figures of its row."""

import hashlib
import json
import math
from dataclasses import dataclass

from experiments.study.grid import Job, code_version
from experiments.study.outcomes import MEASURES, Event, record
from formation.errors import StudyError
from formation.scenario.scenario import Scenario

SERIES_INTERVAL = 0.1
"""Between the samples of the level that are kept [s]."""


@dataclass(frozen=True, slots=True)
class Result:
    """What is known of a job after its flight."""

    key: str
    """Of the job."""
    figures: dict[str, float | None]
    """By measure; None where there is nothing to tell, such as a recovery that never came."""
    trajectory_sha256: str
    """Of the true poses: the same flight to the last bit."""
    series: tuple[float, ...]
    """The level (study/outcomes.py) from the warm-up on, each SERIES_INTERVAL [m]; empty if nobody draws it."""


def simulate(job: Job) -> Result:
    """Fly and measure one job.

    Raises:
        StudyError: this machine has another version of the code than the one who asks.
    """
    from runtime.inprocess import Simulation  # noqa: PLC0415
    from runtime.precompile import ensure_compiled  # noqa: PLC0415  only who flies imports numba

    if job.code != code_version():
        raise StudyError(f"a worker has another version of echelon: expected code {job.code}; got {code_version()}")
    ensure_compiled(_silent)
    scenario = Scenario.model_validate_json(job.scenario)
    measuring = json.loads(job.measuring)
    event = Event.model_validate(measuring["event"]) if measuring["event"] else None
    flight = Simulation(scenario)
    trace = flight.simulate()
    measured = record(scenario, trace, flight.world.counts, measuring["warmup"], event)
    stride = max(1, round(SERIES_INTERVAL / scenario.control_interval))
    return Result(
        key=job.key,
        figures={name: _finite(MEASURES[name].of(measured)) for name in measuring["measures"]},
        trajectory_sha256=hashlib.sha256(trace.poses.astype("<f8").tobytes()).hexdigest(),
        series=tuple(measured.level[::stride].tolist()) if measuring["series"] else (),
    )


def _finite(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None


def _silent(_: str) -> None:
    """The one who asks has compiled already; a worker elsewhere has nobody to tell."""
