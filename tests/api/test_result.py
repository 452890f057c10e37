"""Laws of a result: its errors are by the slots and the ring of each tick, as the summary's, wherever it is from."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import echelon
from network import control
from tests.processes.live import runs
from tests.records.recorded import record

__all__ = ["runs"]
ARRAYS = ("poses", "inputs", "ages", "distance_errors", "angle_errors", "tracking_errors", "centre")
ONE_AWAY: dict[str, Any] = {
    "duration": 6,
    "formation": {"robots": 5},
    "membership": {"changes": [{"robot": 3, "leave": 1, "join": 4}]},
}


def agrees(result: echelon.Result) -> None:
    """The arrays give the figures of the summary."""
    summary = result.summary()
    for name, errors in (("distance_error_m", result.distance_errors), ("angle_error_rad", result.angle_errors)):
        for i, robot in enumerate(summary["robots"].values()):
            there = errors[np.isfinite(errors[:, i]), i]
            assert robot[name]["final"] == (there[-1] if len(there) else None)
            assert robot[name]["max"] == (np.abs(there).max() if len(there) else None)
    assert summary["tracking_error_m"]["final"] == result.tracking_errors[-1]
    assert summary["tracking_error_m"]["max"] == result.tracking_errors.max()


def same(one: echelon.Result, other: echelon.Result) -> None:
    for name in ARRAYS:
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name))


def test_errors_are_by_the_shape_that_was_ordered(tmp_path: Path) -> None:
    simulation = echelon.Simulation(echelon.load("triangle-circle", {"duration": 12}))
    simulation.step(100)
    simulation.reshape("line", spacing=0.15, over=5)
    simulation.step(1100)
    result = simulation.result()
    assert np.abs(result.distance_errors[-1]).max() < 1e-6
    agrees(result)
    same(echelon.read(result.to_parquet(tmp_path / "x.parquet")), result)


@pytest.mark.parametrize("shape", ["keep", "close"])
def test_a_robot_that_is_away_has_no_errors_and_the_others_those_of_the_closed_ring(shape: Any, tmp_path: Path) -> None:
    membership = {**ONE_AWAY["membership"], "shape": shape}
    result = echelon.simulate("ring-16", {**ONE_AWAY, "membership": membership})
    away = np.isnan(result.distance_errors)
    np.testing.assert_array_equal(away, np.isnan(result.angle_errors))
    assert not away[:, [0, 1, 3, 4]].any()
    assert result.times[away[:, 2]].min() == pytest.approx(1.0)
    assert result.times[away[:, 2]].max() == pytest.approx(3.99)
    assert np.nanmax(np.abs(result.distance_errors[390])) < 0.02
    agrees(result)
    table = result.table()
    np.testing.assert_array_equal(table["distance_error_m"], result.distance_errors.ravel())
    same(echelon.read(result.to_parquet(tmp_path / "x.parquet")), result)
    assert result.plot(tmp_path / "x.png").axes


@pytest.mark.parametrize("leave", [0, 0.3])
def test_a_record_has_the_errors_of_the_ring_from_its_start_on(leave: Any, tmp_path: Path) -> None:
    changes = [{"robot": 3, "leave": leave}]
    scenario = echelon.load("ring-16", {"duration": 1, "formation": {"robots": 5}, "membership": {"changes": changes}})
    simulation = record(tmp_path / "x.mcap", scenario)
    found = echelon.read(tmp_path / "x.mcap")
    assert np.isnan(found.distance_errors[-1]).tolist() == [False, False, True, False, False]
    np.testing.assert_array_equal(found.distance_errors, simulation.trace.measured().distance)
    np.testing.assert_array_equal(found.tracking_errors, simulation.trace.errors()[2])


def test_a_parquet_file_without_the_errors_is_refused(tmp_path: Path) -> None:
    result = echelon.simulate("circle", {"duration": 0.1})
    about = {"echelon": '{"scenario": {}, "summary": {}, "ages": ""}'}
    with pytest.raises(echelon.EchelonError, match="of this version; it has no 'tracking'"):
        echelon.read(result.table().to_parquet(tmp_path / "x.parquet", about))


@pytest.mark.processes
def test_the_result_of_a_driven_run_is_by_the_orders_it_was_given(runs: Path) -> None:
    with echelon.launch("drive-me", {"duration": 4}, page=False, paused=True) as run:
        run.drive(0.2, 0.5)
        run.leave(3)
        run.start()
        run.wait()
        result = run.result()
    assert result.tracking_errors[-1] < 0.05
    assert np.hypot(*(result.centre[-1] - result.centre[0])) > 0.3
    assert np.isnan(result.distance_errors[1:, 2]).all()
    agrees(result)


@pytest.mark.processes
def test_a_result_of_a_run_that_goes_on_is_whole_and_of_the_scenario_that_runs_now(runs: Path) -> None:
    with echelon.launch("triangle-circle", {"duration": 60}, page=False, speed=2.0) as run:
        run.wait(until=0.5)
        result = run.result()
        agrees(result)
        assert result.summary()["ticks"] == len(result.inputs) == len(result.poses) - 1
        run._ask(control.UseScenario(scenario="ring-16", overrides={"duration": 0.3}))
        run.start()
        with run._changed:
            run._changed.wait_for(lambda: run.state is not None and run.state.status == "finished", 20.0)
        other = run.result()
    assert (other.scenario.name, other.poses.shape) == ("ring-16", (31, 16, 3))
    agrees(other)
