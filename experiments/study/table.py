"""Tidy tables: one row a trial, in grid order, the same bytes on any number of workers and after any interruption."""

import csv
import os
from collections.abc import Mapping, Sequence
from pathlib import Path

from experiments.study.study import Study, Value
from experiments.trials.result import TrialResult
from experiments.trials.trial import Trial
from formation.errors import StudyError

Cell = Value | None
Row = dict[str, Cell]


def rows(study: Study, trials: Sequence[Trial], results: Sequence[TrialResult]) -> list[Row]:
    """One row a trial: its number, where it stands in the grid, its seed, what was measured."""
    return [
        {"trial": index, **trial.labels, "seed": trial.seed}
        | {name: result.values[name] for name in study.measures}
        | {"trajectory_sha256": result.trajectory_sha256}
        for index, (trial, result) in enumerate(zip(trials, results, strict=True))
    ]


def types(study: Study) -> dict[str, str]:
    """Columns of `rows` and their types in SQL."""
    axes = {axis.name: _type(axis.labels) for axis in study.axes}
    measures = dict.fromkeys(study.measures, "DOUBLE")
    return {"trial": "BIGINT", "scenario": "VARCHAR", **axes, "seed": "BIGINT", **measures} | {
        "trajectory_sha256": "VARCHAR"
    }


def _type(labels: Sequence[Value]) -> str:
    if any(isinstance(label, bool | str) for label in labels):
        return "VARCHAR"
    return "BIGINT" if all(isinstance(label, int) for label in labels) else "DOUBLE"


def write_csv(file: Path, table: Sequence[Mapping[str, Cell]], columns: Sequence[str]) -> Path:
    """Write a table as CSV: numbers in full, nothing where there is no value. Raises StudyError."""
    part = file.with_name(f"{file.name}.part")
    try:
        with part.open("w", encoding="utf-8", newline="") as out:
            writer = csv.DictWriter(out, fieldnames=list(columns), lineterminator="\n")
            writer.writeheader()
            writer.writerows({name: _text(row[name]) for name in columns} for row in table)
        os.replace(part, file)
    except OSError as error:
        raise StudyError(
            f"--out: expected a folder that can be written; got {file.parent} ({error.strerror})"
        ) from None
    return file


def _text(value: Cell) -> str:
    if value is None:
        return ""
    return str(value).lower() if isinstance(value, bool) else str(value)


def write_parquet(csv_file: Path, columns: Mapping[str, str]) -> Path:
    """Write the Parquet file beside a CSV file of these columns; one thread, so that its bytes do not vary."""
    import duckdb  # noqa: PLC0415  a quarter of a second

    file = csv_file.with_suffix(".parquet")
    part = file.with_name(f"{file.name}.part")
    with duckdb.connect(config={"threads": 1}) as database:
        table = database.read_csv(str(csv_file), header=True, auto_detect=False, columns=dict(columns), sep=",")
        table.write_parquet(str(part), compression="zstd")
    os.replace(part, file)
    return file
