"""Laws of a driven run: the orders repeat it, robot 1 alone hears them, and its link matters."""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
import pytest

from formation.errors import EchelonError
from formation.scenario.files import load
from formation.scenario.scenario import Scenario
from network.control import Compare, Drive, GetOrders, GoTo, Operation, Orders, UseController
from runtime import inprocess
from runtime.ghost.shadow import Shadow
from runtime.inprocess import Simulation
from tests.memory_run import MemoryRun, Weather
from world.presence import AgentPresence
from world.rate import Rate
from world.run_control import RunControl
from world.world import World

SHORT = {"duration": 1.5}
COMMANDS = [[0.0, 0.1, 0.0], [0.5, 0.2, 0.5]]


def drive_me(**changes: Any) -> Scenario:
    return load("drive-me", {**SHORT, **changes})


def control(world: World) -> RunControl:
    return RunControl(world, Rate(0.0), AgentPresence(world), go=True)


def driven(simulation: Simulation, orders: Mapping[int, Operation], ticks: int) -> None:
    """Ticks with a user's orders before some of them."""
    desk = control(simulation.world)
    for k in range(ticks):
        if k in orders:
            desk.obey(orders[k])
        simulation.step()


def test_a_live_run_is_repeated_by_its_orders_as_commands_of_the_scenario() -> None:
    """Orders of a user, one that ends by itself, and the way to a point: the same bits from `path.commands`."""
    run = MemoryRun(drive_me(), Weather(seed=3, lost=0.1, doubled=0.3, delayed=0.3, longest=0.05, until=400))
    orders: list[tuple[int, Operation]] = [
        (7, Drive(v=0.1, omega=0.2)),
        (40, Drive(v=0.9, omega=-0.4, seconds=0.2)),
        (90, GoTo(x=-0.3, y=0.3)),
    ]
    for k, order in orders:
        run.run(60.0, lambda k=k: run.world.k >= k)  # type: ignore[misc]
        run.ask(order)
    live = run.finish()
    commands = run.world.summary()["commands"]
    assert len(commands) > len(orders) + 3
    again = drive_me(path={"commands": commands})
    assert inprocess.simulate(again)["trajectory_sha256"] == live
    assert inprocess.simulate(drive_me())["trajectory_sha256"] != live


def test_a_driven_run_is_alike_in_both_engines_whatever_its_links_do() -> None:
    faults = [
        {"link": "driver->1", "latency": 0.1, "jitter": 0.1, "loss": 0.3, "duplicate": 0.1, "corrupt": 0.1},
        {"link": "1->2", "at": 0.6, "until": 0.9, "cut": True},
    ]
    scenario = drive_me(faults=faults, path={"commands": COMMANDS})
    run = MemoryRun(scenario, Weather(seed=1, lost=0.1, doubled=0.2, until=300))
    assert run.finish() == inprocess.simulate(scenario)["trajectory_sha256"]


def test_robot_1_knows_what_its_link_delivers_and_nothing_else() -> None:
    """Agents of a scenario with other commands, fed with the same ticks, do the same."""
    shown, hidden = drive_me(path={"commands": COMMANDS}), drive_me(path={"commands": [[0.0, -0.3, 1.0]]})
    one, other = Simulation(shown), Simulation(shown)
    blind = Simulation(hidden)
    other.agents = blind.agents
    for simulation in (one, other):
        simulation.simulate()
    np.testing.assert_array_equal(one.trace.poses, other.trace.poses)


def test_the_ghost_under_the_live_controller_is_the_driven_episode() -> None:
    live = Simulation(drive_me(path={"commands": COMMANDS}), endless=True)
    assert live.world.endless
    shadow = Shadow(live.world.scenario, "nash", live.world.episode)
    driven(live, {20: Drive(v=0.2, omega=-0.5, seconds=0.3), 80: GoTo(x=0.2, y=0.1)}, 130)
    desk = control(live.world)
    told = Orders.model_validate(desk.obey(GetOrders()))
    assert told.drive_changes == len(told.drives) == live.world.state(seq=1, status="running").driving.orders
    shadow.learn(told.tables, told.drives)
    while shadow.k < live.world.k:
        shadow.step()
    np.testing.assert_array_equal(shadow.message(1).poses, live.world.plant.poses)
    assert not np.array_equal(live.world.plant.poses, drive_me().start_poses())


def speed(simulation: Simulation, robot: int) -> float:
    """Of a robot over the last tenth of a second [m/s]."""
    now, before = simulation.trace.poses[-1, robot - 1], simulation.trace.poses[-11, robot - 1]
    return float(np.hypot(*(now - before)[:2])) / 0.1


def apart(simulation: Simulation) -> float:
    """Distance of the robots' mean position to where the centre is by the orders [m]."""
    return float(simulation.world.state(seq=1, status="running").tracking_error)


def test_without_a_word_of_its_driver_robot_1_stops_and_comes_back_without_a_jump() -> None:
    cut = {"link": "driver->1", "at": 2.0, "until": 6.0, "cut": True}
    ideal = {"preset": "ideal"}
    whole, broken = (
        Simulation(
            load("drive-me", {"duration": 16.0, "bodies": ideal, "faults": f, "path": {"commands": [[0.0, 0.1, 0.0]]}})
        )
        for f in ([], [cut])
    )
    steps: list[float] = []
    for _ in range(1600):
        before = broken.world.plant.poses.copy()
        for simulation in (whole, broken):
            simulation.step()
        steps.append(float(np.hypot(*(broken.world.plant.poses - before)[:, :2].T).max()))
        now = broken.world.now
        if now < 2.4:  # heard at 1.9 s for the last time
            np.testing.assert_array_equal(broken.world.plant.poses, whole.world.plant.poses)
        elif 3.5 < now < 5.9:
            assert max(speed(broken, robot) for robot in (1, 2, 3, 4)) < 1e-3
    assert apart(whole) < 1e-3
    assert apart(broken) < 5e-3
    assert max(steps) < 0.5 * 0.01  # never faster than a robot can be: nothing jumps
    assert broken.world.contacts.count == 0


def test_an_order_that_is_not_said_again_ends() -> None:
    simulation = Simulation(drive_me())
    driven(simulation, {10: Drive(v=0.2, omega=0.0, seconds=0.3)}, 150)
    assert [(round(t, 2), v, omega) for t, v, omega in simulation.world.summary()["commands"]] == [
        (0.1, 0.2, 0.0),
        (0.4, 0.0, 0.0),
    ]
    assert len([event for event in simulation.world.events if event.kind == "drive"]) == 2


def test_an_order_said_again_in_time_goes_on_and_is_one_order() -> None:
    simulation = Simulation(drive_me())
    driven(simulation, {k: Drive(v=0.2, omega=0.0, seconds=0.3) for k in range(10, 150, 10)}, 150)
    assert len(simulation.world.summary()["commands"]) == 1


def test_the_centre_arrives_where_it_is_sent_with_the_robots_round_it() -> None:
    simulation = Simulation(load("drive-me", {"duration": 12.0}))
    driven(simulation, {10: GoTo(x=0.2, y=0.5)}, 1200)
    state = simulation.world.state(seq=1, status="running")
    assert state.driving.goal is None
    assert math.dist(state.centre[:2], (0.2, 0.5)) < 5e-3
    assert math.dist(state.poses[:, :2].mean(axis=0), (0.2, 0.5)) < 2e-2
    assert [event.text.split()[0] for event in simulation.world.events if event.kind == "drive"] == [
        "drives",
        "arrives",
    ]


@pytest.mark.parametrize("operation", [Drive(v=0.1, omega=0.0), GoTo(x=0.0, y=0.0)])
def test_a_path_that_is_not_driven_takes_no_orders(operation: Any) -> None:
    world = World(load("circle"))
    with pytest.raises(EchelonError, match=r'driven \(path.kind = "driven", such as drive-me\); got circle'):
        control(world).obey(operation)


def test_a_reset_begins_without_the_orders_of_before() -> None:
    simulation = Simulation(drive_me())
    driven(simulation, {5: Drive(v=0.2, omega=0.0)}, 20)
    simulation.world.reset()
    state = simulation.world.state(seq=1, status="running")
    assert (state.driving.orders, state.driving.v) == (0, 0.0)


def test_a_controller_that_needs_the_path_is_refused_while_it_is_driven() -> None:
    with pytest.raises(EchelonError, match="needs the path in every robot"):
        control(World(drive_me())).obey(Compare(controller="paper"))
    with pytest.raises(EchelonError, match="needs the path in every robot"):
        control(World(drive_me())).obey(UseController(controller="virtual_structure"))
