"""Waiting: the robots wait for one that cannot keep up, catch up, and otherwise move as if none ever waited."""

# mypy: disable-error-code="arg-type, call-arg, no-any-return, attr-defined"
# (numpy scalars and shapes; what strict typing of numpy makes of test arithmetic)

from typing import Any

import numpy as np
import pytest

from agents.controllers.pair_waiting import HASTE, REVERSE, PairWaiting
from agents.controllers.task import Task
from agents.kernels.unicycle import sample
from formation.arrays import FloatArray
from formation.scenario.files import load
from formation.scenario.scenario import Scenario
from network.messages import Plan
from runtime.inprocess import Simulation, simulate
from tests.builders import plan

STUCK = "disturbances=[{robot=2, at=5, until=9, drive=0.0}]"
QUIET = ("robots={}", "duration=30")


def simulated(*settings: str, name: str = "triangle-circle") -> Simulation:
    simulation = Simulation(load(name, [*QUIET, *settings]))
    simulation.simulate()
    return simulation


def worst(simulation: Simulation) -> FloatArray:
    """The largest |l_e| of any robot at every tick [mm]."""
    return 1e3 * np.abs(simulation.trace.errors()[0]).max(axis=1)


def lags(simulation: Simulation) -> list[float]:
    return [agent._task.lag for agent in simulation.agents.values()]


# ---------------------------------------------------------------- the reference at another time and pace


def test_on_time_the_sampled_reference_is_the_tables_rows_to_the_last_bit() -> None:
    task = Task(load("figure8"), 1)
    block, row = task.block(700)
    ahead = task.ahead(700)
    rows = row + task.stride * np.arange(task.horizon + 1)
    np.testing.assert_array_equal(ahead.slots, block.slots[rows])
    np.testing.assert_array_equal(ahead.inputs, block.inputs[rows[:-1]])


def test_a_lag_is_the_reference_of_earlier_and_between_ticks_it_is_interpolated() -> None:
    task = Task(load("figure8"), 2)
    earlier = task.ahead(500)
    task.lag = 2.0
    late = task.ahead(700)
    np.testing.assert_allclose(late.slots, earlier.slots, atol=1e-12)
    task.lag = 2.005
    between, before = task.ahead(700), Task(load("figure8"), 2).ahead(499)
    np.testing.assert_allclose(between.slots, (earlier.slots + before.slots) / 2, atol=1e-12)


def test_headings_are_interpolated_the_short_way_round() -> None:
    slots = np.zeros((5, 1, 3))
    slots[:, 0, 2] = [3.0, 3.1, -3.1, -3.0, -2.9]
    out, inputs = np.empty((2, 1, 3)), np.empty((1, 1, 2))
    sample(slots, np.ones((5, 1, 2)), 1.5, 1.0, 1.0, out, inputs)
    assert abs(abs(out[0, 0, 2]) - np.pi) < 0.01


@pytest.mark.parametrize("pace", [0.0, 0.5, 1.5])
def test_at_another_pace_the_horizon_covers_more_or_less_of_the_path_and_inputs_scale(pace: Any) -> None:
    task = Task(load("circle"), 1)
    normal = task.ahead(100)
    task.pace = pace
    ahead = task.ahead(100)
    block, row = task.block(100)
    end = row + round(pace * task.stride * task.horizon)
    np.testing.assert_allclose(ahead.slots[-1], block.slots[end], atol=1e-9)
    np.testing.assert_allclose(ahead.inputs, pace * normal.inputs, atol=1e-6)


# ---------------------------------------------------------------- who waits


@pytest.mark.parametrize("settings", [(), ("link.latency=0.5",), ("link.loss=0.5",), ("path={kind='figure8'}",)])
def test_without_trouble_no_robot_waits_and_the_trajectory_is_that_without_waiting(settings: Any) -> None:
    one = simulate(load("triangle-circle", [*QUIET, "duration=8", *settings]))
    two = simulate(load("triangle-circle", [*QUIET, "duration=8", "controller.waits=false", *settings]))
    assert one["trajectory_sha256"] == two["trajectory_sha256"]


@pytest.mark.parametrize("name", ["triangle-corner", "ring-16"])
def test_a_corner_or_a_disordered_start_is_no_reason_to_wait(name: Any) -> None:
    simulation = Simulation(load(name, ["duration=22", "controller.plan_every=5"]))
    highest = 0.0
    while not simulation.finished:
        simulation.step()
        highest = max(highest, *lags(simulation))
    assert highest < 0.05


@pytest.mark.parametrize(("latency", "bound", "duration"), [(0.0, 25.0, 30), (0.5, 50.0, 45)])
def test_the_team_waits_for_a_stuck_robot_and_makes_up_for_it(latency: Any, bound: Any, duration: Any) -> None:
    simulation = simulated(STUCK, f"link.latency={latency}", f"duration={duration}")
    error = worst(simulation)
    assert 2.0 < error[500:].max() < bound
    assert error[1300:].max() < 3.0  # from 4 s after its release on
    assert error[-1] < 0.01
    assert max(lags(simulation)) == 0.0  # the path is caught up
    assert simulation.trace.errors()[2][-1] < 1e-4
    alone = simulated(STUCK, f"link.latency={latency}", "controller.waits=false")
    assert worst(alone)[500:].max() > 2.0 * error[500:].max()


def test_limits_hold_while_the_lag_is_worked_off() -> None:
    simulation = simulated(STUCK, "robots.limits.v=0.06")
    assert np.abs(simulation.trace.inputs[..., 0]).max() <= 0.06
    assert worst(simulation)[-1] < 0.1


@pytest.mark.parametrize(
    "entry",
    [
        "{robot=2, at=5, until=15, drive=0.4}",
        "{robot=1, at=5, until=6, drift=[0.0, -0.08, 0.0]}",
        "{robot=3, at=5, until=6, drift=[0.08, 0.0, 0.5]}",
    ],
)
def test_a_slowed_or_pushed_robot_is_taken_back_into_the_formation(entry: Any) -> None:
    simulation = simulated(f"disturbances=[{entry}]")
    assert worst(simulation)[500:].max() > 2.0
    assert worst(simulation)[-500:].max() < 0.1
    assert simulation.trace.errors()[2][-1] < 1e-3


@pytest.mark.parametrize("settings", [("link.latency=1.0",), ("link.loss=0.9",), ("link.cut=true",), ("link.preset",)])
def test_lags_do_not_feed_themselves_round_the_ring(settings: Any) -> None:
    worse = "link={latency=0.3, jitter=0.2, loss=0.3, burst=10}" if settings == ("link.preset",) else settings[0]
    simulation = Simulation(load("triangle-circle", ["robots={}", "duration=60", STUCK, worse]))
    highest = 0.0
    while not simulation.finished:
        simulation.step()
        highest = max(highest, *lags(simulation))
    assert highest < 4.0 + 2.5  # what the robot lost, and what messages in flight promised beyond it
    assert max(lags(simulation)) < 0.1


# ---------------------------------------------------------------- one robot's book-keeping


def progress(*settings: str) -> tuple[Scenario, Task, PairWaiting]:
    scenario = load("triangle-circle", ["robots={}", *settings])
    task = Task(scenario, 1)
    return scenario, task, PairWaiting(task, scenario.spacing)


def said(k: int, lag: float, lag_rate: float = 0.0) -> Plan:
    return plan(3, k, lag=lag, lag_rate=lag_rate)


def test_a_heard_lag_is_taken_over_and_what_travelled_is_added() -> None:
    _, task, one = progress()
    for k in range(1, 101):
        one.update(k, task.slot(k, 0)[0], said(k, 0.2))
    assert task.lag == pytest.approx(0.2, abs=0.01)
    for k in range(101, 201):
        one.update(k, task.slot(k, 0)[0], said(k - 50, 0.2, lag_rate=1.0))
    assert task.lag == pytest.approx(0.7, abs=0.03)


def test_a_lag_changes_at_a_bounded_rate_and_a_plan_that_has_ended_holds_nobody() -> None:
    _, task, one = progress()
    last = 0.0
    for k in range(1, 301):
        one.update(k, task.slot(k, 0)[0], said(k, 3.0))
        assert -HASTE * 0.01 - 1e-9 <= task.lag - last <= (1.0 + REVERSE) * 0.01 + 1e-9
        assert 0.0 <= task.pace <= 1.0 + HASTE
        assert task.lag <= k * 0.01  # never before the start
        last = task.lag
    for k in range(501, 2000):
        one.update(k, task.slot(k, 0)[0], said(300, 3.0))
    assert task.lag == 0.0


def test_only_who_does_not_move_as_planned_holds_back() -> None:
    _, task, one = progress()
    slot = task.slot(0, 0)[0]
    behind = slot - np.array([0.0, 0.05, 0.0])  # the path begins along y
    for k in range(1, 60):  # behind, but it goes where its plan says
        one.planned(behind, np.zeros((20, 2)))
        one.update(k, behind, None)
    assert task.lag == 0.0
    for k in range(60, 160):  # behind, and it does not
        one.planned(behind, np.full((20, 2), [0.1, 0.0]))
        one.update(k, behind, None)
    assert one.lag_rate == 1.0
    assert task.lag > 0.5
