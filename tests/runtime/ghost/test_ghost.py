"""Laws of the ghost: under the live controller it equals the live episode, and it meets the live faults under any."""

import random
from typing import Any

import numpy as np
import pytest

from formation.errors import FaultError, ScenarioError
from formation.faults import Fault
from formation.link_ids import LinkId, every_link
from formation.scenario.files import load
from formation.schema import MAX_ROBOTS
from network.codec import MAX_BYTES, encode
from network.control import Compare, GetOrders, Orders, Pause, SetFault
from network.requests import Reply
from runtime.ghost.shadow import Shadow
from runtime.inprocess import Simulation
from world.faults import KEPT_CHANGES, TOLD_CHANGES, FaultState
from world.rate import Rate
from world.run_control import RunControl, with_controller
from world.world import World

NOISY = ["noise.slip=0.2", "noise.gyro=0.1", "noise.position=0.001", "noise.heading=0.01"]
SCHEDULE = "faults=[{at=0.5, until=1.2, link='2->3', cut=true}, {at=0.8, link='1->2', loss=0.5, burst=4}]"
LINKS = ["all", "1->2", "2->3", "3->1", "world->2", "3->world"]
CHANGES: list[dict[str, Any]] = [{"latency": 0.1, "jitter": 0.05}, {"loss": 0.6}, {"cut": True}, {"duplicate": 0.5}]


def follow(shadow: Shadow, world: World) -> None:
    """What the ghost's process does when the world has said a state."""
    while shadow.tables_known < world.faults.changes:
        shadow.learn(world.faults.since(shadow.tables_known))
    while shadow.k < world.k:
        shadow.step()


def disturb(world: World, draws: random.Random) -> None:
    """Somebody moves a slider, or clears it."""
    link = draws.choice(LINKS)
    if draws.random() < 0.3:
        world.clear_faults(link)
    else:
        world.change_fault(link, draws.choice(CHANGES), draws.choice([None, world.now + 0.3]))


@pytest.mark.parametrize("controller", ["nash", "paper", "leader_follower"])
@pytest.mark.parametrize("every", [1, 7, 250], ids=["in step", "in jumps", "begun late"])
def test_under_the_live_controller_the_ghost_is_the_live_episode_to_the_last_bit(controller: Any, every: int) -> None:
    scenario = load("triangle-circle", [*NOISY, SCHEDULE, f"controller.name={controller}", "link.latency=0.02"])
    live, draws = Simulation(scenario, endless=True), random.Random(every)
    shadow = Shadow(scenario, controller, live.world.episode)
    for _ in range(250):
        if draws.random() < 0.1:
            disturb(live.world, draws)
        live.step()
        if live.world.k % every == 0:
            follow(shadow, live.world)
            ghost, state = shadow.message(1), live.world.state(seq=1, status="running")
            assert ghost.stamp == state.stamp
            np.testing.assert_array_equal(ghost.poses, state.poses)
            np.testing.assert_array_equal(ghost.distance_errors, state.distance_errors)
    assert live.world.faults.changes > 10  # there was something to repeat
    assert np.abs(ghost.poses - scenario.start_poses()).max() > 0.1


def test_under_another_controller_the_ghost_meets_the_same_faults_and_moves_differently() -> None:
    scenario, draws = load("triangle-circle", [*NOISY, "link.loss=0.3", "link.burst=4"]), random.Random(3)
    live = Simulation(scenario, endless=True)
    shadow = Shadow(scenario, "leader_follower", live.world.episode)
    for _ in range(250):
        if draws.random() < 0.1:
            disturb(live.world, draws)
        live.step()
    follow(shadow, live.world)
    ours, theirs = ({i: a.counts() for i, a in simulation.agents.items()} for simulation in (live, shadow._simulation))
    assert sum(counts.lost for counts in ours.values()) > 20
    assert ours == theirs
    assert np.abs(shadow.message(1).poses - live.world.plant.poses).max() > 1e-3


def test_the_live_controller_keeps_its_weights_as_a_ghost() -> None:
    scenario = load("triangle-circle", ["controller.own_weight=20"])
    live = Simulation(scenario, endless=True)
    tuned, plain = Shadow(scenario, "nash", 0), Shadow(with_controller(scenario, "nash"), "nash", 0)
    for _ in range(100):
        live.step()
    for shadow in (tuned, plain):
        follow(shadow, live.world)
    np.testing.assert_array_equal(tuned.message(1).poses, live.world.plant.poses)
    assert np.abs(plain.message(1).poses - live.world.plant.poses).max() > 1e-9


def test_a_ghost_may_be_of_a_controller_that_runs_in_one_process_only() -> None:
    live = Simulation(load("triangle-circle"), endless=True)
    for _ in range(20):
        live.step()
    shadow = Shadow(load("triangle-circle"), "centralised", 0)
    follow(shadow, live.world)
    assert 0.0 < np.abs(shadow.message(1).poses - live.world.plant.poses).max() < 0.1


def test_such_a_ghost_goes_on_when_the_live_world_was_lost() -> None:
    """Its agents begin anew; who plans for all of them sees where they are."""
    live = Simulation(load("triangle-circle", ["bodies=turtlebot3"]), endless=True)
    for _ in range(40):
        live.step()
    shadow = Shadow(live.world.given, "centralised", 0)
    shadow.resume_at([20])
    follow(shadow, live.world)
    assert shadow.k == live.world.k
    assert shadow.world.resumed == [20]


def test_a_reset_begins_the_tables_of_faults_anew() -> None:
    simulation = Simulation(load("triangle-circle", [SCHEDULE]), endless=True)
    simulation.world.change_fault("3->1", {"latency": 0.2}, None)
    for _ in range(150):
        simulation.step()
    times = [at for at, _ in simulation.world.faults.since(0)]
    assert times == pytest.approx([0.0, 0.0, 0.5, 0.8, 1.2])
    simulation.world.reset()
    assert simulation.world.faults.since(0) == [(0.0, {LinkId(3, 1): Fault(latency=0.2)})]


@pytest.mark.parametrize(("robots", "parts"), [(64, [TOLD_CHANGES, 5]), (MAX_ROBOTS, [2] * ((TOLD_CHANGES + 5) // 2))])
def test_tables_are_told_in_parts_that_fit_a_message_however_full_they_are(robots: int, parts: list[int]) -> None:
    faults = FaultState(load("ring-16", [f"formation.robots={robots}"]))
    worst = Fault(
        latency=0.123456789,
        jitter=0.123456789,
        distribution="uniform",
        loss=0.123456789,
        burst=3.0,
        duplicate=0.123456789,
        reorder=0.123456789,
        keep_order=True,
        rate=123.0,
        corrupt=0.123456789,
        cut=True,
    )
    for n in range(TOLD_CHANGES + 5):
        faults.impose(dict.fromkeys(every_link(robots), worst.model_copy(update={"burst": 3.0 + n})))
        faults.update(float(n))
    begins = [sum(parts[:number]) for number in range(len(parts) + 1)]
    assert [len(faults.since(begin)) for begin in begins] == [*parts, 0]
    first = faults.since(0)
    told = [(at, {link: fault.model_dump() for link, fault in table.items()}) for at, table in first]
    assert len(encode(Reply(True, value={"episode": 1, "changes": 30, "tables": told}))) < MAX_BYTES


def test_an_episode_with_more_changes_than_are_kept_says_so() -> None:
    faults = FaultState(load("triangle-circle"))
    for n in range(KEPT_CHANGES + 2):
        faults.impose({LinkId(1, 2): Fault(latency=0.001 * (1 + n % 2))})
        faults.update(float(n))
    with pytest.raises(FaultError, match=str(KEPT_CHANGES)):
        faults.since(0)
    assert faults.since(KEPT_CHANGES + 1) == [(KEPT_CHANGES + 1.0, {LinkId(1, 2): Fault(latency=0.002)})]


def orders(world: World) -> RunControl:
    roster: Any = None
    return RunControl(world, Rate(1.0), roster, go=True)


def test_the_world_says_which_ghost_is_wanted_and_what_the_faults_were() -> None:
    world = World(load("triangle-circle"))
    desk = orders(world)
    desk.obey(Compare(controller="paper"))
    assert desk.compare == "paper"
    desk.obey(Pause())
    desk.obey(SetFault(link="1->2", changes={"loss": 0.5}))
    told = Orders.model_validate(desk.obey(GetOrders()))
    assert (told.episode, told.changes) == (world.episode, 2)
    assert told.tables == [(0.0, {}), (0.0, {LinkId(1, 2): Fault(loss=0.5)})]
    assert Orders.model_validate(desk.obey(GetOrders(tables=1))).tables == told.tables[1:]
    desk.obey(Compare(controller="off"))
    assert desk.compare == ""


def test_a_ghost_of_no_controller_is_refused_with_the_choices() -> None:
    desk = orders(World(load("triangle-circle")))
    with pytest.raises(ScenarioError, match=r"nash, paper, .*off"):
        desk.obey(Compare(controller="ghost"))
    assert desk.compare == ""
