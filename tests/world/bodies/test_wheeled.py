"""Laws of wheeled bodies and their sensors (docs/theory.md, section 11)."""

import math
from typing import Any

import numpy as np
import pytest

from formation.arrays import FloatArray
from formation.scenario.files import load
from world.bodies.draws import BLOCK, Draws
from world.bodies.sensors import Measured
from world.bodies.wheeled import WheeledBodies

DT = 0.01


def bodies(**keys: Any) -> WheeledBodies:
    return WheeledBodies(load("triangle-circle", {"bodies": keys}))


def wheels(of: WheeledBodies, command: tuple[float, float], ticks: int) -> FloatArray:
    """Odometry (ticks, 2) of robot 1 under a constant command."""
    out = []
    for _ in range(ticks):
        of.move(np.tile(command, (3, 1)))
        out.append(of.odometry[0])
    return np.array(out)


def test_without_lag_wheels_do_what_they_are_told_within_the_limits() -> None:
    assert wheels(bodies(), (0.3, -0.5), 1)[0].tolist() == [0.3, -0.5]
    assert wheels(bodies(), (9.0, -9.0), 1)[0].tolist() == [0.5, -2.0]


@pytest.mark.parametrize("lag", [0.05, 0.2])
def test_wheels_close_their_gap_with_the_time_constant(lag: float) -> None:
    of = bodies(lag=lag)
    start = of.odometry[0].copy()
    ticks = round(lag / DT)
    reached = wheels(of, (0.3, 1.0), ticks)[-1]
    np.testing.assert_allclose(reached - start, (np.array([0.3, 1.0]) - start) * (1.0 - math.exp(-1.0)), rtol=1e-9)


def test_wheels_accelerate_no_faster_than_they_can() -> None:
    speeds = wheels(bodies(lag=0.01, acceleration=1.0, turn_acceleration=5.0), (0.5, 2.0), 30)
    steps = np.abs(np.diff(speeds, axis=0))
    assert steps[:, 0].max() == pytest.approx(1.0 * DT)
    assert steps[:, 1].max() == pytest.approx(5.0 * DT)


def test_a_command_acts_after_the_delay_and_not_before() -> None:
    of = bodies(delay=0.05)
    before = of.odometry[0, 0]
    speeds = wheels(of, (0.3, 0.0), 7)[:, 0]
    assert np.all(np.abs(speeds[:5] - before) < 1e-3)  # until then the slot's own inputs act
    assert speeds[5:].tolist() == [0.3, 0.3]


@pytest.mark.parametrize("horizon", [2, 20])
@pytest.mark.parametrize("scenario", ["triangle-circle", "drive-me"])
def test_a_delay_may_be_longer_than_what_is_known_of_the_way(scenario: str, horizon: int) -> None:
    """Of a driven formation that is two horizons, of any other 20 s: the rest of it stands."""
    changes = {"bodies": {"preset": "ideal", "delay": 10}, "controller": {"horizon": horizon}}
    of = WheeledBodies(load(scenario, changes))
    start, n = of.odometry, len(of.poses)
    for _ in range(1000):
        of.move(np.full((n, 2), 0.25))
    assert np.abs(of.odometry - start).max() < 0.2
    of.move(np.full((n, 2), 0.25))
    assert of.odometry.tolist() == [[0.25, 0.25]] * n


def test_scales_and_offsets_differ_between_robots_and_stay_within_their_bounds() -> None:
    of = bodies(scale=0.05, turn_scale=0.05, turn_offset=0.02)
    before = of.poses.copy()
    of.move(np.tile([0.3, 0.0], (3, 1)))
    way = np.hypot(*(of.poses[:, :2] - before[:, :2]).T) / (0.3 * DT)
    turn = (of.poses[:, 2] - before[:, 2]) / DT
    assert np.all(np.abs(way - 1.0) <= 0.05)
    assert np.all(np.abs(turn) <= 0.02)
    assert len(set(way.round(9))) == len(set(turn.round(9))) == 3


@pytest.mark.parametrize("slip_time", [0.0, 0.1])
def test_slip_has_its_deviation_whether_white_or_correlated(slip_time: float) -> None:
    of = bodies(slip=0.2, slip_time=slip_time)
    ways = []
    for _ in range(6000):
        before = of.poses
        of.move(np.tile([0.3, 0.0], (3, 1)))
        ways.append(np.hypot(*(of.poses[:, :2] - before[:, :2]).T) / (0.3 * DT) - 1.0)
    slips = np.array(ways)
    assert slips.std() == pytest.approx(0.2, rel=0.1)
    alike = np.corrcoef(slips[1:, 0], slips[:-1, 0])[0, 1]
    assert alike == pytest.approx(math.exp(-DT / slip_time) if slip_time else 0.0, abs=0.05)


@pytest.mark.parametrize("correlation", [0.0, 0.5, 1.0])
def test_gusts_have_their_deviation_duration_and_correlation(correlation: float) -> None:
    of = bodies(gusts={"sigma": 0.01, "time": 0.2, "correlation": correlation})
    pushes = []
    for _ in range(20_000):
        before = of.poses
        of.move(np.zeros((3, 2)))
        pushes.append((of.poses - before)[:, :2] / DT)
    x = np.array(pushes)[:, :, 0]
    assert x.std() == pytest.approx(0.01, rel=0.15)
    assert np.corrcoef(x[:, 0], x[:, 2])[0, 1] == pytest.approx(correlation, abs=0.15)
    assert np.corrcoef(x[20:, 1], x[:-20, 1])[0, 1] == pytest.approx(math.exp(-1.0), abs=0.1)


def measured(keys: dict[str, Any], ticks: int = 200) -> tuple[list[Measured | None], list[FloatArray]]:
    """What sensors deliver tick by tick, and the true poses."""
    of = bodies(**keys)
    found, truth = [], []
    for _ in range(ticks):
        truth.append(of.poses)
        found.append(of.measure())
        of.move(np.tile([0.2, 0.1], (3, 1)))
    return found, truth


def test_localisation_is_of_its_own_time_and_comes_at_its_rate_and_age() -> None:
    found, truth = measured({"localisation": {"rate": 20.0, "age": 0.08}})
    for k, one in enumerate(found):
        if one is None:
            assert (k - 8) % 5 or k < 8
        else:
            assert one.tick == k - 8
            np.testing.assert_array_equal(one.poses, truth[one.tick])


def test_a_dropout_takes_one_robots_localisation_by_its_stamp() -> None:
    keys = {"localisation": {"age": 0.1, "dropouts": [{"robot": 2, "at": 0.5, "until": 0.7}]}}
    for one in measured(keys)[0]:
        if one is not None:
            assert (2 in one.localised) == (not 50 <= one.tick < 70)
            assert {1, 3} <= set(one.localised)


def test_relative_sensing_is_the_neighbour_in_the_own_frame() -> None:
    found, truth = measured({"relative": {"sigma": 0.0}}, 5)
    for one, poses in zip(found, truth, strict=True):
        assert one is not None
        for i in range(3):
            c, s = math.cos(poses[i, 2]), math.sin(poses[i, 2])
            x, y = one.relatives[i]
            np.testing.assert_allclose(poses[i, :2] + [c * x - s * y, s * x + c * y], poses[i - 1, :2], atol=1e-12)


def test_the_share_of_outliers_is_as_asked_for() -> None:
    found, truth = measured({"localisation": {"outliers": 0.1, "outlier_size": 0.5}}, 3000)
    off = [np.abs(one.poses - poses).max(axis=1) > 1e-9 for one, poses in zip(found, truth, strict=True) if one]
    assert np.mean(off) == pytest.approx(0.1, abs=0.02)


def test_a_draw_depends_on_seed_stream_robot_and_tick_alone() -> None:
    few, many = Draws(7, 2, 2, 3), Draws(7, 2, 5, 3)
    late = many.at(BLOCK + 3).copy()
    np.testing.assert_array_equal(few.at(5), many.at(5)[:2])
    np.testing.assert_array_equal(many.at(BLOCK + 3), late)
    assert not np.array_equal(few.at(5), Draws(8, 2, 2, 3).at(5))
    assert not np.array_equal(few.at(5), Draws(7, 3, 2, 3).at(5))


def test_noise_of_one_kind_does_not_change_the_draws_of_another() -> None:
    both = measured({"slip": 0.2, "localisation": {"position": 0.01}}, 30)
    alone = measured({"slip": 0.2}, 30)
    np.testing.assert_array_equal(both[1][-1], alone[1][-1])
