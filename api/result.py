"""What came of an episode, as arrays with shapes and units."""

import base64
import glob
import io
import json
from collections.abc import Mapping
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from api.arguments import check_folder, unwritable
from api.table import Table
from formation.arrays import FloatArray, frozen, timeline
from formation.errors import EchelonError
from formation.scenario.files import parse
from formation.scenario.scenario import Scenario
from world.measures.trace import Errors

ABOUT = "echelon"
"""Key of a Parquet file under which scenario, summary and what has no column are kept."""
COLUMNS = {
    "poses": ("x", "y", "theta"),
    "inputs": ("v", "omega"),
    "distance": ("distance_error_m",),
    "angle": ("angle_error_rad",),
}
"""Of the same file, by array."""


class Result:
    """An episode of n robots over T ticks; rows of T + 1 include the start.

    Example:
        >>> import echelon
        >>> result = echelon.simulate("triangle-circle", {"duration": 2})
        >>> result.poses.shape, result.inputs.shape
        ((201, 3, 3), (200, 3, 2))
        >>> bool(abs(result.distance_errors[-1]).max() < 0.03)
        True
    """

    def __init__(
        self,
        scenario: Scenario,
        poses: FloatArray,
        inputs: FloatArray,
        ages: FloatArray,
        errors: Errors,
        summary: Mapping[str, Any],
    ) -> None:
        """Of a scenario's episode; arrays as of the properties."""
        self.scenario = scenario
        """What was simulated."""
        self.poses: FloatArray = frozen(poses)
        """(T + 1, n, 3) true poses [m, m, rad]."""
        self.inputs: FloatArray = frozen(inputs)
        """(T, n, 2) commands that the bodies got [m/s, rad/s]."""
        self.ages: FloatArray = frozen(ages)
        """(T, n) age of the plan that each robot acted on [s]; NaN without an answer."""
        self._errors = Errors(*map(frozen, errors))
        self._summary = dict(summary)

    @cached_property
    def times(self) -> FloatArray:
        """(T + 1,) of `poses` [s]."""
        return timeline(0, len(self.poses), self.scenario.control_interval)

    @property
    def distance_errors(self) -> FloatArray:
        """(T + 1, n) distance of each robot and its upstream neighbour, less what it should be [m]; NaN while away."""
        return self._errors.distance

    @property
    def angle_errors(self) -> FloatArray:
        """(T + 1, n) direction from each robot to its upstream one, less what it should be [rad]; NaN while away."""
        return self._errors.angle

    @property
    def tracking_errors(self) -> FloatArray:
        """(T + 1,) distance of the mean position of the robots in the ring to where it should be [m]."""
        return self._errors.tracking

    @property
    def centre(self) -> FloatArray:
        """(T + 1, 2) where the formation's centre should be [m]."""
        return self._errors.centre

    @property
    def trajectory_sha256(self) -> str:
        """Of `poses` as little-endian float64: the same trajectory to the last bit."""
        return str(self._summary["trajectory_sha256"])

    @property
    def events(self) -> list[dict[str, Any]]:
        """What happened: t [s], kind, severity, text."""
        return list(self._summary["events"])

    def summary(self) -> dict[str, Any]:
        """The measures that `echelon run --json` prints."""
        return dict(self._summary)

    def table(self) -> Table:
        """A row for every robot at every tick; the last row of a robot has no inputs."""
        ticks, n = self.poses.shape[:2]
        inputs = np.concatenate([self.inputs, np.full((1, n, 2), np.nan)])
        pattern = {"distance_error_m": self.distance_errors, "angle_error_rad": self.angle_errors}
        flat = {name: values.reshape(-1) for name, values in pattern.items()}
        x, y, theta = self.poses.reshape(-1, 3).T
        v, omega = inputs.reshape(-1, 2).T
        robot = np.tile(np.arange(1, n + 1), ticks)
        own = {"x": x, "y": y, "theta": theta, "v": v, "omega": omega}
        return Table({"t": np.repeat(self.times, n), "robot": robot, **own, **flat})

    def to_csv(self, file: str | Path) -> Path:
        """Write `table()` as CSV. Raises EchelonError: the file cannot be written."""
        return self.table().to_csv(file)

    def to_parquet(self, file: str | Path) -> Path:
        """Write `table()` as Parquet, from which `echelon.read` makes the same result. Raises EchelonError likewise."""
        kept = {"scenario": json.loads(self.scenario.model_dump_json(exclude_unset=True)), "summary": self._summary}
        arrays = {"ages": self.ages, "tracking": self.tracking_errors, "centre": self.centre}
        return self.table().to_parquet(
            file, {ABOUT: json.dumps({**kept, **{name: _text(values) for name, values in arrays.items()}})}
        )

    def plot(self, file: str | Path | None = None) -> Any:
        """Draw the ways of the robots and the pattern errors, excursions shaded.

        Args:
            file: where to write the picture, if anywhere; its suffix says the format.

        Returns:
            The matplotlib Figure.

        Raises:
            EchelonError: the file cannot be written, or the suffix names no format.
        """
        from experiments.report.episode import draw  # noqa: PLC0415  matplotlib

        found = self._summary.get("excursions", ())
        drawn = draw(self.scenario, self.times, self.poses, self.centre, self.distance_errors, self.angle_errors, found)
        if file is not None:
            try:
                drawn.savefig(check_folder(file))
            except (OSError, ValueError) as error:
                raise unwritable(file, error) from None
        return drawn

    def _repr_html_(self) -> str:
        picture = io.BytesIO()
        self.plot().savefig(picture, format="png")
        data = base64.b64encode(picture.getvalue()).decode()
        return f'<p>{self!r}</p><img alt="ways and pattern errors" src="data:image/png;base64,{data}">'

    def __repr__(self) -> str:
        scenario = self.scenario
        return (
            f"<Result of {scenario.name} with {scenario.controller.name}, seed {scenario.seed}: {scenario.size} robots,"
            f" {self.times[-1]:g} s, {self.trajectory_sha256[:12]}>"
        )


def read(file: str | Path, *, episode: int = -1) -> Result:
    """The result that `Result.to_parquet` wrote, or that of a record of a lockstep run (.mcap).

    Args:
        file: to read.
        episode: of a record, from 0; by default the last one. It is simulated again, and compared with the record.

    Raises:
        EchelonError: the file is none, or the record cannot be simulated again.

    Example:
        >>> import echelon, tempfile
        >>> result = echelon.simulate("triangle-circle", {"duration": 1})
        >>> again = echelon.read(result.to_parquet(tempfile.mkdtemp() + "/x.parquet"))
        >>> again.trajectory_sha256 == result.trajectory_sha256
        True
    """
    if Path(file).suffix == ".mcap":
        from records.record import load  # noqa: PLC0415  of records only
        from runtime.repetition import repeat  # noqa: PLC0415  numba

        found = repeat(load(Path(file)), episode)
        return Result(found.scenario, found.poses, found.inputs, found.ages, found.errors, found.summary)
    if not Path(file).is_file():
        raise EchelonError(f"{file}: expected a file of Result.to_parquet; there is none")
    return _read_parquet(str(file))


def _read_parquet(name: str) -> Result:
    """The result that `Result.to_parquet` wrote. Raises EchelonError: the file is none."""
    import duckdb  # noqa: PLC0415  a quarter of a second

    try:
        one = glob.escape(name)  # DuckDB takes a pattern
        pairs = dict(duckdb.execute("SELECT key, value FROM parquet_kv_metadata(?)", [one]).fetchall())
        kept = json.loads(pairs[ABOUT.encode()])
        wanted = ", ".join(column for columns in COLUMNS.values() for column in columns)
        columns = duckdb.execute(f"SELECT {wanted} FROM read_parquet(?)", [one]).fetchnumpy()
        ages, tracking, centre = (_array(kept[key]) for key in ("ages", "tracking", "centre"))
    except (duckdb.Error, KeyError, ValueError) as error:
        why = f"it has no {error}" if isinstance(error, KeyError) else str(error).splitlines()[0]
        raise EchelonError(f"{name}: expected a file of Result.to_parquet of this version; {why}") from None
    scenario = parse(kept["scenario"], where=name)
    n = scenario.size
    poses, inputs, distance, angle = (
        np.stack([np.ma.filled(columns[column], np.nan) for column in group], axis=1).reshape(-1, n, len(group))
        for group in COLUMNS.values()
    )
    errors = Errors(distance[..., 0], angle[..., 0], tracking, centre.reshape(-1, 2))
    return Result(scenario, poses, inputs[:-1], ages.reshape(-1, n), errors, kept["summary"])


def _text(values: FloatArray) -> str:
    return base64.b64encode(values.astype("<f8").tobytes()).decode()


def _array(text: str) -> FloatArray:
    return np.frombuffer(base64.b64decode(text), dtype="<f8")
