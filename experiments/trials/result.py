"""What is kept of a trial, and the same as plain data for journals and for other machines."""

from base64 import b64decode, b64encode
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any, Self

import numpy as np

from experiments.trials.trial import Trial
from formation.arrays import FloatArray, timeline
from formation.metrics import pattern_errors, tracking_error
from formation.scenario.scenario import Scenario
from network.values import Excursion


@dataclass(frozen=True, slots=True, eq=False)
class Signals:
    """Signals of a trial over time; T ticks, n robots."""

    times: FloatArray
    """(T + 1,) [s]."""
    poses: FloatArray
    """(T + 1, n, 3) [m, m, rad]."""
    inputs: FloatArray
    """(T, n, 2) [m/s, rad/s]."""
    centre: FloatArray
    """(T + 1, 2) the reference p_r, where the formation's centre should be [m]."""
    distance: FloatArray
    """(T + 1, n) l_e [m]."""
    angle: FloatArray
    """(T + 1, n) psi_e [rad]."""
    tracking: FloatArray
    """(T + 1,) distance of the robots' mean position to p_r [m]."""
    gaps: FloatArray
    """(G, n) Nash gap; G = 0 unless it was asked for."""
    excursions: tuple[Excursion, ...] = ()
    """The ledger, by the time at which they began."""

    @classmethod
    def of(
        cls,
        scenario: Scenario,
        poses: FloatArray,
        inputs: FloatArray,
        gaps: FloatArray,
        excursions: tuple[Excursion, ...] = (),
    ) -> Self:
        """All signals from those that are not functions of others."""
        times = timeline(0, len(poses), scenario.control_interval)
        reference = scenario.reference()
        centre = reference.centre(times)
        distance, angle = pattern_errors(poses, reference.positions(times))
        tracking = tracking_error(poses, centre)
        return cls(times, poses, inputs, centre, distance, angle, tracking, gaps, excursions)

    def after(self, start: float, stop: float = np.inf) -> slice:
        """Rows of `times` from `start` to `stop` [s]; of a trial cut before `start`, the last row."""
        first, last = np.searchsorted(self.times, (start - 1e-9, stop + 1e-9)).tolist()
        first = min(first, len(self.times) - 1)
        return slice(first, max(last, first + 1))


@dataclass(frozen=True, slots=True, eq=False)
class TrialResult:
    """What is known of a trial after it was simulated."""

    values: Mapping[str, float | None]
    """By measure; None where there is no value, such as a recovery that never came."""
    trajectory_sha256: str
    """Of the true poses: the same trajectory to the last bit."""
    series: FloatArray
    """(S,) the level (experiments/trials/measures.py) from the warm-up on, each SERIES_INTERVAL [m]; S = 0 unless it
    was asked for."""
    signals: Signals | None = None
    """If they were asked for."""

    def plain(self) -> dict[str, Any]:
        """As JSON has it; of the signals only what the others follow from."""
        kept = self.signals
        return {
            "values": dict(self.values),
            "trajectory_sha256": self.trajectory_sha256,
            "series": self.series.tolist(),
            "signals": kept
            and {
                **{name: _text(getattr(kept, name)) for name in ("poses", "inputs", "gaps")},
                "excursions": [asdict(one) for one in kept.excursions],
            },
        }


def result_of(trial: Trial, plain: Mapping[str, Any]) -> TrialResult:
    """The result of a trial from its plain data."""
    signals = None
    if plain["signals"] is not None:
        scenario = trial.load()
        shapes = {"poses": (-1, scenario.size, 3), "inputs": (-1, scenario.size, 2), "gaps": (-1, scenario.size)}
        arrays = {name: _array(plain["signals"][name], shape) for name, shape in shapes.items()}
        ledger = tuple(Excursion(**one) for one in plain["signals"]["excursions"])
        signals = Signals.of(scenario, **arrays, excursions=ledger)
    return TrialResult(plain["values"], plain["trajectory_sha256"], np.array(plain["series"], dtype=float), signals)


def _text(values: FloatArray) -> str:
    return b64encode(values.astype("<f8").tobytes()).decode("ascii")


def _array(text: str, shape: tuple[int, ...]) -> FloatArray:
    return np.frombuffer(b64decode(text), dtype="<f8").reshape(shape)
