"""Verdicts follow the numbers: each claim of the report, judged on made-up signals."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from experiments.paper import claims, noisy, stuck
from experiments.paper.bounds import bounds
from experiments.report.report import grade
from experiments.trials.result import Signals
from formation.arrays import FloatArray
from network.values import Excursion

PATHS = ("figure8", "circle", "sinusoid", "spiral")


def made_up(
    distance: Any = 0.0, angle: Any = 0.0, tracking: Any = 0.0, inputs: Any = None, seconds: float = 100.0
) -> Signals:
    """Signals at 10 Hz of two robots with these errors, constants or functions of time."""
    times = np.linspace(0.0, seconds, round(seconds * 10) + 1)

    def signal(what: Any) -> FloatArray:
        return np.asarray(what(times) if callable(what) else np.full(times.shape, float(what)))

    pair = [np.column_stack([signal(what)] * 2) for what in (distance, angle)]
    moves = np.zeros((len(times) - 1, 2, 2)) if inputs is None else np.broadcast_to(inputs, (len(times) - 1, 2, 2))
    none = np.zeros((0, 2))
    return Signals(times, np.zeros((len(times), 2, 3)), moves, none, pair[0], pair[1], signal(tracking), none)


def wave(size: float) -> Any:
    return lambda t: size * np.sin(t)


def test_a_grade_is_what_its_parts_are() -> None:
    assert grade([True, True]) == "holds"
    assert grade([True, False]) == "holds in part"
    assert grade([False]) == "does not hold"
    with pytest.raises(ValueError, match="at least one part"):
        grade([])


@pytest.mark.parametrize(
    ("paper", "outcome"), [((0.001, 0.001), "holds"), ((0.001, 0.1), "holds in part"), ((0.1, 0.1), "does not hold")]
)
def test_errors_are_small_beside_a_follower_that_errs_more(paper: Any, outcome: Any) -> None:
    trials = {"leader_follower": made_up(0.05, 0.05), "paper": made_up(*paper), "nash": made_up()}
    assert claims.follower_errs(trials).outcome == outcome


@pytest.mark.parametrize(
    ("paper", "outcome"), [((1e-4, 1e-4), "holds"), ((1e-4, 0.1), "holds in part"), ((0.1, 0.1), "does not hold")]
)
def test_an_objective_is_optimal_if_nobody_does_much_better(paper: Any, outcome: Any) -> None:
    distance, tracking = paper
    trials = {"paper": made_up(distance, 0.0, tracking), "nash": made_up(1e-4, 0.0, 1e-4)}
    assert claims.both_objectives(trials).outcome == outcome


def test_the_outer_robot_of_a_left_turn_is_the_right_one() -> None:
    left = made_up(inputs=[[0.2, 0.1], [0.1, 0.1]])
    right = made_up(inputs=[[0.2, -0.1], [0.1, -0.1]])
    assert claims.outer_is_faster(left) == 1.0
    assert claims.outer_is_faster(right) == 0.0
    assert claims.turns({"paper": left, "nash": left}).outcome == "holds"
    assert claims.turns({"paper": right, "nash": left}).outcome == "does not hold"


@pytest.mark.parametrize(("size", "outcome"), [(0.001, "holds"), (0.04, "does not hold")])
@pytest.mark.parametrize("what", ["distance", "angle"])
def test_boxes_are_smaller_if_medians_and_quartiles_are(what: Any, size: Any, outcome: Any) -> None:
    paths = {
        p: {"leader_follower": made_up(wave(0.05), wave(0.05)), "paper": made_up(wave(size), wave(size))} for p in PATHS
    }
    assert claims.boxes_smaller(paths, what).outcome == outcome
    paths["spiral"] = {name: made_up(wave(0.05), wave(0.05)) for name in ("leader_follower", "paper")}
    assert claims.boxes_smaller(paths, what).outcome == ("holds in part" if outcome == "holds" else outcome)


@pytest.mark.parametrize(
    ("peak", "end", "outcome"), [(0.005, 0.0, "holds"), (0.05, 0.0, "holds in part"), (0.05, 0.02, "does not hold")]
)
def test_a_corner_is_a_small_deviation_that_goes_away(peak: Any, end: Any, outcome: Any) -> None:
    trial = made_up(lambda t: np.where((t > 20) & (t < 30), peak, end))
    assert claims.corner_recovers(trial, 0.1, 20.0).outcome == outcome


@pytest.mark.parametrize(
    ("peak", "until", "outcome"), [(0.009, 29.0, "holds"), (0.02, 29.0, "holds in part"), (0.02, 31.0, "does not hold")]
)
def test_the_corner_is_beaten_within_its_bounds(peak: Any, until: Any, outcome: Any) -> None:
    trial = made_up(lambda t: np.where((t > 20) & (t < until), peak, 1e-6))
    assert claims.corner_beaten(trial, 20.0).outcome == outcome


@pytest.mark.parametrize(
    ("error", "outcome"),
    [
        (lambda t: np.full_like(t, 0.005), "holds"),
        (lambda t: np.full_like(t, 0.05), "holds in part"),
        (lambda t: 0.001 * t, "does not hold"),
    ],
)
def test_errors_that_grow_are_not_bounded(error: Any, outcome: Any) -> None:
    assert claims.circle_bounded(made_up(error), 0.1).outcome == outcome


@pytest.mark.parametrize(
    ("median", "peak", "best", "outcome"),
    [
        (1e-5, 1e-5, 1e-6, "holds"),
        (1e-5, 4e-4, 1e-6, "holds"),
        (1e-5, 1e-3, 1e-6, "holds in part"),
        (1e-4, 1e-3, 1e-6, "holds in part"),  # the spiral may have 1.5 mm
        (1e-2, 1e-2, 1e-3, "does not hold"),
    ],
)
def test_nash_keeps_its_bounds_or_not(median: Any, peak: Any, best: Any, outcome: Any) -> None:
    trial = made_up(lambda t: np.where(t < 1.0, peak, median))
    table, verdict = bounds({path: {"nash": trial, "centralised": made_up(best)} for path in PATHS})
    assert verdict.outcome == outcome
    assert [row[0] for row in table.rows] == list(PATHS)
    assert table.rows[0][1] == pytest.approx(median * 1e3)
    assert table.rows[0][3] == pytest.approx(peak * 1e3)


def test_the_centralised_optimum_counts_only_where_it_is_visible() -> None:
    nash = made_up(wave(4e-5))
    near = bounds({"circle": {"nash": nash, "centralised": made_up(1e-5)}})[0]
    assert near.rows[0][-1] is None  # 0.01 mm: below what is compared
    far = bounds({"circle": {"nash": nash, "centralised": made_up(6e-5)}})[0]
    assert far.rows[0][-1] == pytest.approx(4 / 6 / np.sqrt(2), rel=0.01)


def hold(worst: float, until: float, path: float = 0.0) -> Signals:
    return made_up(lambda t: np.where((t > 20) & (t < until), worst, 0.0), 0.0, path, seconds=60.0)


@pytest.mark.parametrize(
    ("trial", "outcome"),
    [(hold(0.02, 27.0), "holds"), (hold(0.02, 29.0), "holds in part"), (hold(0.06, 61.0, 0.1), "does not hold")],
)
def test_a_stuck_robot_is_judged_by_size_and_time(trial: Any, outcome: Any) -> None:
    assert stuck.verdict({("nash", link): trial for link in stuck.LINKS}).outcome == outcome


def test_a_formation_that_never_comes_back_is_called_so() -> None:
    worst, again, path = stuck.measure(hold(0.06, 61.0, 0.1))
    assert worst == pytest.approx(0.06)
    assert again is None
    assert path is None
    table = stuck.table({("nash", link): hold(0.06, 61.0, 0.1) for link in stuck.LINKS})
    assert table.rows[0][2] == "never"


def test_the_ledger_of_a_stuck_robot_names_who_when_and_why() -> None:
    seen = Excursion(1, 2, 20.5, 0.02, 24.0, until=25.0, recovery=1.0, cause="robot 2: slow", cause_at=20.0)
    lasting = Excursion(2, 3, 40.0, 0.01, 41.0)
    trials = {link: replace(made_up(), excursions=(seen, lasting)) for link in stuck.LINKS}
    rows = stuck.ledger({("nash", link): trial for link, trial in trials.items()}).rows
    assert rows[0][1:] == ("robot 2", 20.5, 20.0, 1.0, "robot 2: slow")
    assert rows[1][1:] == ("robot 3", 40.0, 10.0, "never", "none found")
    assert [row[0] for row in rows] == [f"plans {link}" for link in stuck.LINKS for _ in range(2)]


@pytest.mark.parametrize(("grown", "outcome"), [(1.01, "holds"), (1.04, "holds in part"), (1.2, "does not hold")])
def test_growth_under_faults_is_measured_seed_by_seed(grown: Any, outcome: Any) -> None:
    on_time = np.array([[1.0, 1.0], [2.0, 1.0]])
    found = {
        (belief, condition.name): on_time * (1.0 if condition.name == "on time" else grown)
        for belief in (noisy.AGED, noisy.FRESH)
        for condition in noisy.CONDITIONS
    }
    assert noisy.growth(found, noisy.AGED, "1 s late") == pytest.approx(grown - 1.0)
    assert noisy.verdict(found).outcome == outcome
