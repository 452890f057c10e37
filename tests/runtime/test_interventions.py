"""Laws of what users do to the robots: it is the scenario's own mechanism, alike in both engines, and repeated."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from formation.errors import EchelonError
from formation.formation_spec import MAX_CHANGES
from formation.scenario.files import load
from formation.scenario.reshaping import change_of, reshaped
from formation.scenario.scenario import Scenario
from network.control import GetOrders, Operation, Orders, Pause, Start, Step
from network.interventions import Move, Push, Release, Reshape
from records.file import RecordFile
from records.record import load as load_record
from runtime.ghost.shadow import Shadow
from runtime.inprocess import Simulation
from runtime.recording import Recording
from runtime.verification import verify
from tests.memory_run import MemoryRun, Weather
from world.presence import AgentPresence
from world.rate import Rate
from world.run_control import RunControl
from world.world import World

TICKS = 250
NOISE = {"slip": 0.1, "position": 0.001}
ALL: dict[int, Operation] = {
    20: Push(robot=1, kind="gust", seconds=0.5),
    60: Push(robot=2, kind="stuck"),
    75: Push(robot=3, kind="slippery", seconds=0.4),
    90: Release(robot=2),
    110: Move(robot=3, dx=0.03, dy=-0.02),
    120: Push(robot=2, kind="blind", seconds=0.3),
    140: Reshape(shape="line", spacing=0.15),
    170: Push(robot=1, kind="slow"),
}
"""By the tick from which on they count."""


def circle(**changes: Any) -> Scenario:
    return load("triangle-circle", {"duration": TICKS * 0.01, "noise": NOISE, **changes})


def simulated(scenario: Scenario, orders: Mapping[int, Operation] = ALL, *, endless: bool = False) -> Simulation:
    simulation = Simulation(scenario, endless=endless)
    for k in range(TICKS):
        if k in orders:
            simulation.world.intervene(orders[k])
        simulation.step()
    return simulation


def test_what_acts_is_known_at_every_tick_though_it_is_looked_up_when_it_is_due() -> None:
    pushes = [{"robot": 1, "at": 0.29, "until": 0.57, "drive": 0.5}, {"robot": 2, "at": 0.35, "drive": 0.8}]
    world = World(circle(disturbances=pushes))
    for k in range(80):
        if k == 40:
            world.intervene(Push(robot=3, kind="gust", seconds=0.07))
        elif k == 60:
            world.intervene(Release(robot=2))
        acting = [entry for entry in world.interventions._all if entry.on(world.now)]
        assert list(world.interventions.acting) == acting
        world.advance({})


@pytest.fixture(scope="module")
def whole() -> Simulation:
    return simulated(circle())


def control(world: World) -> RunControl:
    return RunControl(world, Rate(0.0), AgentPresence(world), go=True)


@pytest.mark.parametrize("name", ["triangle-circle", "follow-the-leader", "drive-me"])
def test_both_engines_do_the_same_at_the_tick_that_is_computed_next(name: str) -> None:
    """Between processes that lose and delay messages, as in one; while paused, at the tick with which it resumes."""
    driven = {"path": {"commands": [[0.0, 0.1, 0.2]]}} if name == "drive-me" else {}
    scenario = load(name, {"duration": 2.0, **driven})
    run = MemoryRun(scenario, Weather(seed=2, lost=0.1, doubled=0.2, delayed=0.2, longest=0.03, until=300))
    wanted: list[tuple[int, Operation]] = [
        (40, Push(robot=2, kind="stuck", seconds=0.4)),
        (90, Move(robot=3, dx=0.02, dy=0.02)),
        (110, Reshape(spacing=0.14)),
    ]
    for k, operation in wanted:
        run.run(60.0, lambda k=k: run.world.k >= k)  # type: ignore[misc]
        run.ask(Pause())
        run.run(0.2)
        stands = run.world.k
        run.ask(operation)
        run.run(0.2)
        assert run.world.k == stands
        run.ask(Start())
    live = run.finish()
    done = run.world.interventions.since(0)
    assert [one.kind for one in done] == ["push", "push", "shape"]
    again = Simulation(scenario)
    while not again.finished:
        for one in done:
            if one.tick == again.world.k:
                again.world.repeat(one)
        again.step()
    assert again.world.summary()["trajectory_sha256"] == live
    assert (
        Simulation(scenario)
        .simulate()
        .summary({}, again.world.convergence, again.world.at_limits, [])["trajectory_sha256"]
        != live
    )


def test_a_push_is_a_disturbance_of_the_scenario(whole: Simulation) -> None:
    listed = [
        one.value for one in whole.world.interventions.since(0) if one.kind == "push" and one.value.get("drive") != 0.0
    ]
    stuck = {"robot": 2, "at": 0.6, "until": 0.9, "drive": 0.0}
    orders = {k: order for k, order in ALL.items() if isinstance(order, Reshape)}
    again = simulated(circle(disturbances=[*listed, stuck]), orders)
    np.testing.assert_array_equal(again.trace.poses, whole.trace.poses)


def test_after_a_hundred_shapes_an_order_says_what_to_do() -> None:
    scenario = load("triangle-circle")
    changes = [change_of(scenario, float(at), shape="line") for at in range(MAX_CHANGES + 1)]
    with pytest.raises(
        EchelonError, match=f"expected at most {MAX_CHANGES} changes of it in an episode; a reset begins"
    ):
        reshaped(scenario, changes)


def test_a_shape_that_is_ordered_is_one_of_the_scenario_but_for_what_is_seen_of_it_ahead(whole: Simulation) -> None:
    (done,) = [one for one in whole.world.interventions.since(0) if one.kind == "shape"]
    scripted = circle(formation={"changes": [done.value]}).reference()
    for k in (100, 140, 200, 240):
        wanted, found = scripted.block(k), whole.world.reference.block(k)
        np.testing.assert_array_equal(wanted.slots, found.slots)
    quiet = simulated(load("triangle-circle", {"duration": 60.0}), {140: Reshape(shape="line", spacing=0.15)})
    while not quiet.finished:
        quiet.step()
    last = quiet.trace.poses[-1]
    apart = np.hypot(*(last[:, None, :2] - last[None, :, :2]).transpose(2, 0, 1))
    np.testing.assert_allclose(np.sort(apart[np.triu_indices(3, 1)]), [0.15, 0.15, 0.30], atol=1e-3)


@pytest.mark.parametrize("controller", ["nash", "consensus"])
def test_a_ghost_repeats_it_at_the_same_tick(controller: str) -> None:
    scenario = circle(duration=60.0)
    live = simulated(scenario, endless=True)
    told = Orders.model_validate(control(live.world).obey(GetOrders()))
    state = live.world.state(seq=1, status="running")
    assert told.intervention_changes == len(told.interventions) == state.interventions == len(ALL)
    shadow = Shadow(scenario, controller, 0)
    shadow.learn(told.tables, told.drives, told.interventions)
    while shadow.k < live.world.k:
        shadow.step()
    assert np.array_equal(shadow.poses, live.world.plant.poses) == (controller == "nash")
    assert np.abs(shadow.poses - live.world.plant.poses)[:, :2].max() < 0.3


def test_a_record_has_it_and_is_verified(tmp_path: Path, whole: Simulation) -> None:
    simulation = Simulation(circle())
    with RecordFile(tmp_path / "run.mcap") as file:
        recording = Recording(simulation, file, 0, "default")
        for k in range(TICKS):
            if k in ALL:
                simulation.world.intervene(ALL[k])
            recording.step()
    np.testing.assert_array_equal(simulation.trace.poses, whole.trace.poses)
    record = load_record(tmp_path / "run.mcap")
    kinds = [order.kind for order in record.episodes[0].orders]
    assert kinds.count("push") == 6
    assert kinds.count("shape") == kinds.count("release") == 1
    (verdict,) = verify(record)
    assert (verdict.ticks, verdict.difference) == (TICKS + 1, "")


def test_what_is_done_is_in_the_log_and_what_acts_now_is_shown(whole: Simulation) -> None:
    log = [(event.stamp, event.text) for event in whole.world.events if event.kind == "push"]
    assert (0.2, "robot 1: pushed at (0, 0.05) m/s, for 0.5 s") in log
    assert (0.7, "robot 1: no longer pushed at (0, 0.05) m/s") in [(round(t, 9), text) for t, text in log]
    assert (0.9, "robot 2: no longer stuck") in log
    assert any(text.startswith("the shape becomes line") for _, text in log)
    assert [(one.robot, one.text) for one in whole.world.state(seq=1, status="running").pushes] == [
        (1, "slowed to 50%")
    ]


def test_a_robot_that_is_moved_is_carried_by_just_that_and_once() -> None:
    still = {"path": {"kind": "driven"}, "bodies": {"preset": "ideal"}, "duration": 1.0, "controller": {"name": "nash"}}
    moved, alone = (Simulation(load("drive-me", still)) for _ in range(2))
    moved.world.intervene(Move(robot=2, dx=0.05, dy=-0.03))
    commands: Any = {}
    for simulation in (moved, alone):
        for _ in range(80):
            simulation.world.advance(commands)
    offset = moved.world.plant.poses - alone.world.plant.poses
    expected = np.zeros((4, 3))
    expected[1, :2] = 0.05, -0.03
    np.testing.assert_allclose(offset, expected, atol=1e-12)


def test_a_reset_takes_it_all_back(whole: Simulation) -> None:
    live = simulated(circle(duration=60.0), endless=True)
    live.world.reset()
    assert not live.world.interventions.count
    assert not live.world.state(seq=1, status="running").pushes
    assert live.world.scenario is live.world.given
    assert live.world.setup().changes == []


@pytest.mark.parametrize(
    ("operation", "text"),
    [
        (Push(robot=4, kind="gust"), "expected 1 to 3; got 4"),
        (Release(robot=9), "expected 1 to 3; got 9"),
        (Reshape(), "expected the name of a shape, a spacing, or both"),
        (Reshape(shape="square"), "expected a shape for 3 robots"),
        (Step(), "expected push, move, release or shape"),
    ],
)
def test_what_cannot_be_done_is_refused_in_a_line_and_changes_nothing(operation: Operation, text: str) -> None:
    world = World(circle())
    with pytest.raises(EchelonError, match=text) as error:
        world.intervene(operation)
    assert "\n" not in str(error.value)
    assert not world.interventions.count
    assert world.scenario is world.given
