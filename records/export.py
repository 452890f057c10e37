"""Tables of a record: where the robots were, and their errors; as CSV or Parquet."""

import csv
import os
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Literal

from formation.errors import EchelonError
from records.record import Record

Format = Literal["csv", "parquet"]
Row = tuple[float | int, ...]
POSES = {
    "episode": "BIGINT",
    "t": "DOUBLE",
    "robot": "BIGINT",
    "x": "DOUBLE",
    "y": "DOUBLE",
    "theta": "DOUBLE",
    "v": "DOUBLE",
    "omega": "DOUBLE",
}
"""Columns and their types: exact poses and inputs of every tick in a record of full detail, else twenty a second."""
ERRORS = {
    "episode": "BIGINT",
    "t": "DOUBLE",
    "robot": "BIGINT",
    "distance_error": "DOUBLE",
    "angle_error": "DOUBLE",
    "tracking_error": "DOUBLE",
}


def poses(record: Record) -> Iterator[Row]:
    """Rows of POSES [s, m, m, rad, m/s, rad/s]."""
    for number, episode in enumerate(record.episodes, 1):
        if record.about.get("detail") == "full":
            for tick, exact in sorted(episode.poses.items()):
                for robot, (pose, inputs) in enumerate(zip(exact, episode.inputs[tick], strict=True), 1):
                    yield (number, tick * episode.interval, robot, *pose.tolist(), *inputs.tolist())
        else:
            for (time, robot), values in sorted(episode.shown.items()):
                yield (number, episode.seconds(time), robot, *map(float, values))


def errors(record: Record) -> Iterator[Row]:
    """Rows of ERRORS [s, m, rad, m]."""
    for number, episode in enumerate(record.episodes, 1):
        for time, (tracking, distance, angle) in sorted(episode.errors.items()):
            for robot, (l_e, psi_e) in enumerate(zip(distance.tolist(), angle.tolist(), strict=True), 1):
                yield number, episode.seconds(time), robot, l_e, psi_e, tracking


def export(record: Record, kind: Format) -> list[Path]:
    """Write both tables beside the record; their files.

    Raises:
        EchelonError: they cannot be written.
    """
    tables = (("poses", POSES, poses(record)), ("errors", ERRORS, errors(record)))
    try:
        return [_write(record.path, name, columns, rows, kind) for name, columns, rows in tables]
    except OSError as error:
        raise EchelonError(f"cannot write beside {record.path}: {error.strerror}") from None


def _write(path: Path, name: str, columns: dict[str, str], rows: Iterable[Row], kind: Format) -> Path:
    file = path.with_name(f"{path.stem}-{name}.{kind}")
    part, text = file.with_name(f"{file.name}.part"), file.with_name(f"{file.name}.csv.part")
    with text.open("w", encoding="utf-8", newline="") as out:
        writer = csv.writer(out, lineterminator="\n")
        writer.writerow(columns)
        writer.writerows(rows)
    if kind == "parquet":
        _write_parquet(part, text, columns)
        text.unlink()
    else:
        part = text
    os.replace(part, file)
    return file


def _write_parquet(file: Path, text: Path, columns: dict[str, str]) -> None:
    """The table of a CSV file."""
    import duckdb  # noqa: PLC0415  a quarter of a second

    with duckdb.connect(config={"threads": 1}) as database:
        table = database.read_csv(str(text), header=True, auto_detect=False, columns=columns, sep=",")
        table.write_parquet(str(file), compression="zstd")
