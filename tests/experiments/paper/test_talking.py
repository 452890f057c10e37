"""Laws of the report's chapter on what messages are worth."""

import numpy as np
import pytest

from experiments.paper import talking
from experiments.paper.chapters import Extent
from experiments.study import study
from experiments.trials.result import Signals


def signals(error: float, jitter: float) -> Signals:
    """A trial of 20 s in which every l_e is +-error [m], and v goes up and down by jitter [m/s]."""
    times = np.arange(0.0, 20.0, 0.01)
    sign = np.where(np.arange(len(times)) % 2, 1.0, -1.0)
    inputs = np.zeros((len(times) - 1, 3, 2))
    inputs[:, :, 0] = 0.5 * jitter * sign[1:, None]
    zeros = np.zeros((len(times), 3))
    poses = np.zeros((len(times), 3, 3))
    return Signals(
        times, poses, inputs, zeros[:, :2], error * sign[:, None] + zeros, zeros, zeros[:, 0], np.zeros((0, 3))
    )


def found(worse: dict[str, float]) -> dict[tuple[str, str, str], tuple[float, float]]:
    """Cells in which messages are worth as much as claimed and more, but for some rows' factors."""
    better = {"A": 0.9, "E": 0.05, "G": 0.8, "H": 0.8} | worse
    return {
        (row, network, controller): (better[row] if controller == "nash" else 1.0, 1.0)
        for row, network, controller in talking._cells()
    }


def test_what_is_measured_is_the_error_of_all_robots_and_the_change_from_tick_to_tick() -> None:
    assert talking.measure(signals(0.002, 0.0005)) == pytest.approx((2.0, 0.5))


def test_every_trial_is_one_of_the_studys_grid() -> None:
    labels = study.load(talking.STUDY).labels
    trials = talking._trials(Extent(seeds=1))
    assert len({trial.name for trial in trials}) == len(trials) == len(talking._cells())
    for row, network, controller in talking._cells():
        assert row in labels["row"]
        assert network in labels["network"]
        assert controller in labels["controller"]


@pytest.mark.parametrize(
    ("worse", "outcome"),
    [
        ({}, "holds"),
        ({"E": 0.15}, "holds in part"),
        ({"A": 1.1}, "holds in part"),
        ({"A": 1.1, "E": 0.5, "G": 1.0}, "does not hold"),
    ],
)
def test_the_verdict_follows_the_figures(worse: dict[str, float], outcome: str) -> None:
    assert talking.verdict(found(worse)).outcome == outcome


def test_the_table_leaves_a_gap_where_nobody_sees() -> None:
    rows = {row[0][0]: row for row in talking.table(found({})).rows if isinstance(row[0], str)}
    assert rows["A"][5] is None
    assert rows["G"][5] is not None
