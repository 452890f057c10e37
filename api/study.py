"""Many trials at once: a grid of keys and seeds, on all cores or a cluster, as one table."""

import os
import tempfile
from collections.abc import Collection, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from api.arguments import whole
from api.scenarios import load, tell
from api.table import Table, column
from experiments.study import grid as grids
from experiments.study.study import parse
from experiments.study.table import rows, types
from experiments.trials.batch import Place, run_batch
from experiments.trials.result import result_of
from formation.errors import EchelonError
from formation.scenario.scenario import Scenario
from formation.validation import shown
from runtime.own_code import check_main

MEASURES = ("distance_rms_m", "distance_max_m", "tracking_rms_m")
"""What is measured unless the caller names measures."""


def study(
    scenario: str | os.PathLike[str] | Scenario = "triangle-circle",
    overrides: Mapping[str, Any] | None = None,
    *,
    grid: Mapping[str, Collection[Any]],
    seeds: int = 10,
    measures: Sequence[str] = MEASURES,
    warmup: float = 0.0,
    controller: str | type | None = None,
    bodies: str | type | None = None,
    folder: str | Path | None = None,
    workers: int | None = None,
    cluster: str | None = None,
) -> Table:
    """Simulate a grid of trials.

    Args:
        scenario: as in `load`.
        overrides: what differs from it in every trial, as nested data.
        grid: values by key, {"link.latency": [0, 0.3]}, or by a name of your own what each of its labels stands for,
            {"law": {"deaf": {"controller": {"name": "virtual_structure"}}, "nash": {}}}. All combinations count.
        seeds: seeds 0, 1, ... so many; every point of the grid meets all of them.
        measures: columns, of those that the manual lists.
        warmup: measures start at this simulated time [s].
        controller: as in `load`.
        bodies: as in `load`.
        folder: keeps a journal, from which a study that was interrupted goes on; if absent, nothing is kept.
        workers: processes; one per core, if absent.
        cluster: address of the scheduler of a Dask cluster, instead of workers here.

    Returns:
        A row per trial: `trial`, `scenario`, a column per entry of the grid (dots become underscores), `seed`, the
        measures in SI units (NaN where there is no value), `trajectory_sha256`.

    Raises:
        EchelonError: a key, value or measure is wrong, or a trial failed.

    Example:
        >>> import echelon
        >>> table = echelon.study("circle", {"duration": 1}, grid={"link.latency": [0, 0.3]}, seeds=2, workers=1)
        >>> table.columns[:4], len(table)
        (['trial', 'scenario', 'link_latency', 'seed'], 4)
    """
    check_main("study")
    _check(grid, measures)
    workers = None if workers is None else whole("workers", workers, 1)
    base = load(scenario, overrides, controller=controller, bodies=bodies)
    with tempfile.TemporaryDirectory(prefix="echelon-study-") as temporary:
        file = Path(temporary) / f"{base.name}.json"
        file.write_text(base.model_dump_json(exclude_unset=True), encoding="utf-8")
        raw = {
            "name": base.name,
            "scenarios": [str(file)],
            "axes": [_axis(key, values) for key, values in grid.items()],
            "seeds": seeds,
            "measures": list(measures),
            "warmup": warmup,
        }
        wanted = parse(raw, where="study")
        trials = grids.trials(wanted)
        place = Place(Path(folder) if folder is not None else Path(temporary), workers, cluster)
        found = run_batch(trials, place, tell=tell, progress=_silent)
    results = [result_of(trial, plain) for trial, plain in zip(trials, found, strict=True)]
    table = rows(wanted, trials, results)
    return Table({name: column([row[name] for row in table]) for name in types(wanted)})


def _check(grid: object, measures: object) -> None:
    """Refuse what is no grid, and no list of measures. Raises EchelonError."""
    if not isinstance(grid, Mapping):
        raise EchelonError(f'grid: expected values by key, such as {{"link.latency": [0, 0.3]}}; got {shown(grid)}')
    for key, values in grid.items():
        if not isinstance(key, str):
            raise EchelonError(f"grid: expected keys such as link.latency; got {shown(key)}")
        if isinstance(values, str) or not isinstance(values, Iterable):
            raise EchelonError(f"grid: expected values of {key}, such as [0, 0.3]; got {shown(values)}")
    if isinstance(measures, str) or not isinstance(measures, Iterable):
        raise EchelonError(f"measures: expected a list of names; got {shown(measures)}")


def _axis(key: str, values: Collection[Any]) -> dict[str, Any]:
    """An axis of a study file, from an entry of the grid."""
    name = key.replace(".", "_").lower()
    if isinstance(values, Mapping):
        return {"name": name, "choices": {label: dict(changes) for label, changes in values.items()}}
    return {"name": name, "key": key, "values": list(values)}


def _silent(*_: object) -> None:
    """Progress in lines is told by the batch itself."""
