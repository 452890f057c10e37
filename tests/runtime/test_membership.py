"""Laws of the ring's members: it closes over who leaves and opens for who joins, and only who plays counts."""

from pathlib import Path

import numpy as np
import pytest

from formation.errors import EchelonError, ScenarioError
from formation.link_ids import LinkId, plan_links
from formation.pattern import downstream, upstream
from formation.scenario.files import load
from formation.scenario.scenario import Scenario
from network.interventions import Join, Leave, Reshape
from records.record import load as read
from runtime.ghost.shadow import Shadow
from runtime.inprocess import Simulation
from runtime.replay.rows import rows
from runtime.verification import verify
from tests.memory_run import MemoryRun
from tests.records.recorded import record
from world.members import Members
from world.world import World

AWAY = (4.0, 9.0)
"""From when to when robot 2 is away [s]."""


def scenario(*settings: str, name: str = "ring-16", robots: int = 5) -> Scenario:
    """A ring whose robot 2 leaves, and joins again."""
    change = f"membership.changes=[{{robot=2, leave={AWAY[0]}, join={AWAY[1]}}}]"
    return load(name, [f"formation.robots={robots}", "duration=14", change, *settings])


@pytest.mark.parametrize("away", [(), {2}, {2, 3}, {1, 5}])
def test_the_ring_of_those_who_stay_is_one_ring(away: set[int]) -> None:
    members = set(range(1, 6)) - set(away)
    robot, seen = min(members), []
    while robot not in seen:
        seen.append(robot)
        assert upstream(downstream(robot, 5, away), 5, away) == robot
        robot = downstream(robot, 5, away)
    assert set(seen) == members
    assert [link.sender for link in plan_links(5, away=away)] == sorted(members)


@pytest.fixture(scope="module")
def driven() -> Simulation:
    simulation = Simulation(scenario())
    simulation.simulate()
    return simulation


def test_the_others_keep_their_places_and_who_joins_comes_back(driven: Simulation) -> None:
    trace = driven.trace
    distance, _, tracking = trace.errors()
    away = (trace.times > AWAY[0]) & (trace.times < AWAY[1])
    assert not distance[away, 1].any()
    assert np.abs(distance[(trace.times > AWAY[1] - 0.5) & away]).max() < 2e-3
    assert tracking[(trace.times > AWAY[1] - 0.5) & away].max() < 2e-3
    standing = trace.poses[round(100 * AWAY[0]) + 50 : round(100 * AWAY[1]), 1]
    assert np.ptp(standing, axis=0).max() < 1e-9
    assert np.abs(distance[-1]).max() < 5e-3


def test_who_is_away_has_no_excursion(driven: Simulation) -> None:
    """Nor has the robot that heard it; when it joins, it is far from its place at first."""
    at = [excursion.at for excursion in driven.world.ledger.newest(100)]
    assert not [time for time in at if AWAY[0] - 0.5 < time < AWAY[1] - 0.1]


def test_only_time_in_the_ring_counts(driven: Simulation) -> None:
    whole = Simulation(load("ring-16", ["formation.robots=5", "duration=4"]))
    whole.simulate()
    summary = driven.world.summary()
    texts = [event["text"] for event in summary["events"] if event["kind"] == "agent"]
    assert texts[:2] == ["robot 2 leaves the ring: robot 3 hears robot 1", "robot 2 joins the ring"]
    before = round(100 * AWAY[0])
    np.testing.assert_array_equal(driven.trace.poses[:before], whole.trace.poses[:before])
    gone = Simulation(load("ring-16", ["formation.robots=5", "duration=1", "membership.changes=[{robot=2, leave=0}]"]))
    gone.simulate()
    assert gone.world.summary()["robots"]["2"]["distance_error_m"]["rms"] is None


def test_faults_of_the_closed_ring_are_those_of_its_links() -> None:
    world = World(scenario("link.loss=0.25"))
    world.members.leave(3)
    world._close_ring()
    assert world.faults.table[LinkId(2, 4)].loss == 0.25
    assert LinkId(2, 3) not in world.faults.table
    world.change_fault("2->4", {"cut": True}, None)
    assert world.faults.table[LinkId(2, 4)].cut


def test_an_agent_that_is_gone_for_the_patience_leaves_and_joins_when_it_is_back() -> None:
    members, everybody = Members(load("ring-16", ["formation.robots=4", "membership.patience=0.5"])), {1, 2, 3, 4}
    left = []
    for k in range(200):
        members.look(k, everybody - ({2} if 20 <= k < 120 else set()))
        left.append(bool(members.away))
    assert left.index(True) == 70
    assert left[70:120] == [True] * 50
    assert not any(left[120:])


def test_two_robots_stay_whoever_is_gone_and_a_run_without_agents_has_nobody_leave() -> None:
    members = Members(load("ring-16", ["formation.robots=4"]))
    for k in range(1000):
        members.look(k, {1})
    assert members.away == {2, 3}
    other = Members(load("ring-16", ["formation.robots=4"]))
    for k in range(1000):
        other.look(k, set())
    assert not other.away
    never = Members(load("ring-16", ["formation.robots=4", "membership.patience=0"]))
    for k in range(1000):
        never.look(k, {1, 2})
    assert not never.away


def test_users_are_told_why_a_robot_cannot_leave_or_join() -> None:
    members = Members(load("triangle-circle"))
    with pytest.raises(EchelonError, match="in the ring already"):
        members.join(1)
    members.leave(2)
    with pytest.raises(EchelonError, match="robot 2 has left it"):
        members.leave(2)
    with pytest.raises(EchelonError, match="at least 2 robots"):
        members.leave(3)
    with pytest.raises(EchelonError, match="expected 1 to 3; got 9"):
        members.join(9)
    members.join(2)
    assert not members.away


def test_without_the_leader_nobody_tells_the_path_and_an_event_names_it() -> None:
    simulation = Simulation(load("follow-the-leader", ["duration=6", "membership.changes=[{robot=1, leave=2}]"]))
    simulation.simulate()
    assert any("nobody tells the robots the path" in event.text for event in simulation.world.events)
    assert np.abs(simulation.trace.inputs[-1]).max() < 0.02


@pytest.mark.parametrize("name", ["follow-the-leader", "drive-me"])
def test_with_another_leader_the_formation_goes_on(name: str) -> None:
    """Its robots see those upstream in the closed ring, as their agents take it."""
    settings = ["duration=5", "path.leader=next", "membership.changes=[{robot=1, leave=1, join=4}]"]
    settings.append("robots.avoid=false")  # who has left stands in the way
    driven = ["path.commands=[[0, 0.1, 0.3]]"] if name == "drive-me" else []
    simulation = Simulation(load(name, [*settings, *driven]))
    simulation.simulate()
    assert [event.text for event in simulation.world.events if event.text.endswith("tells the others the path")] == [
        "robot 2 tells the others the path",
        "robot 1 tells the others the path",
    ]
    distance, _, tracking = simulation.trace.errors()
    alone = (simulation.trace.times > 2.5) & (simulation.trace.times < 4.0)
    assert tracking[alone].max() < 0.01
    assert np.abs(distance[alone]).max() < 0.01


def test_followers_follow_the_next_robot_if_the_first_leaves() -> None:
    settings = ["controller.name=leader_follower", "path.radius=0.5", "membership.changes=[{robot=1, leave=1}]"]
    simulation = Simulation(load("ring-16", ["formation.robots=5", "duration=5", *settings]))
    simulation.simulate()
    assert simulation.trace.errors()[2][-1] < 0.05


def test_with_close_those_who_stay_take_the_shape_for_as_many_as_they_are_in_both_engines() -> None:
    task = scenario("membership.shape=close")
    simulation = Simulation(task)
    while simulation.world.now < AWAY[1] - 0.1:
        simulation.step()
    places = simulation.world.scenario.offsets.after(AWAY[0])[[0, 2, 3, 4]]
    apart = np.hypot(*(places[:, None] - places[None]).T)
    np.testing.assert_allclose(np.sort(apart, axis=0)[1:3], 0.1, err_msg="a square of four")
    state = simulation.world.state(seq=0, status="running")
    assert max(np.abs(state.distance_errors).max(), state.tracking_error) < 3e-3
    simulation.simulate()
    assert np.abs(simulation.trace.errors()[0][-1]).max() < 5e-3
    shadow = Shadow(task, "nash", 0)
    shadow.learn([], [], simulation.world.interventions.since(0))
    live = MemoryRun(scenario("membership.shape=close", "duration=5"))
    live.finish()
    assert live.world.trace is not None
    np.testing.assert_array_equal(live.world.trace.poses, simulation.trace.poses[: len(live.world.trace.poses)])
    while shadow.k < 500:
        shadow.step()
    np.testing.assert_array_equal(shadow.poses, simulation.trace.poses[500])


def test_a_shape_that_a_user_orders_meanwhile_is_for_those_who_stay() -> None:
    world = World(load("ring-16", ["formation.robots=5", "membership.shape=close"]), endless=True)
    world.intervene(Leave(robot=2))
    world.intervene(Reshape(shape="line"))
    world.intervene(Leave(robot=4))
    final = world.scenario.offsets.after(0.0)
    assert np.ptp(final[[0, 2, 4], 0]) < 1e-9
    np.testing.assert_allclose(np.sort(final[[0, 2, 4], 1]), [-0.1, 0.0, 0.1], atol=1e-9)


@pytest.mark.parametrize(
    ("change", "line"),
    [
        ("{robot=9, leave=1}", r"membership.changes\[0\].robot: expected 1 to 5; got 9"),
        ("{robot=2, leave=3, join=1}", "expected join > leave; got join 1 and leave 3"),
    ],
)
def test_a_change_that_cannot_be_is_refused(change: str, line: str) -> None:
    with pytest.raises(ScenarioError, match=line):
        load("ring-16", ["formation.robots=5", f"membership.changes=[{change}]"])


def test_a_controller_that_plans_for_all_refuses() -> None:
    with pytest.raises(ScenarioError, match="centralised plans for all robots"):
        Simulation(scenario("controller.name=centralised"))


def test_a_record_of_it_is_verified_and_a_ghost_repeats_what_users_ask(tmp_path: Path) -> None:
    record(tmp_path / "run.mcap", scenario("duration=5", "link.loss=0.2"))
    (verdict,) = verify(read(tmp_path / "run.mcap"))
    assert (verdict.difference, verdict.ticks) == ("", 501)
    (episode,) = read(tmp_path / "run.mcap").episodes
    _, distance, _ = episode.errors[max(episode.errors)]
    assert np.flatnonzero(np.isnan(distance)).tolist() == [1]
    shown = [row for row in rows(tmp_path / "run.mcap") if row.state.stamp > AWAY[0] + 0.7]
    assert {(tuple(row.state.away), float(row.state.distance_errors[1])) for row in shown} == {((2,), 0.0)}
    assert str(shown[-1].statuses[3].link) == "1->3"
    live = Simulation(load("ring-16", ["formation.robots=5", "duration=4"]))
    for k in range(300):
        if k == 100:
            live.world.intervene(Leave(robot=4))
        if k == 220:
            live.world.intervene(Join(robot=4))
        live.step()
    shadow = Shadow(live.world.given, "nash", 0)
    shadow.learn(live.world.faults.since(0), [], live.world.interventions.since(0))
    while shadow.k < live.world.k:
        shadow.step()
    np.testing.assert_array_equal(shadow.poses, live.world.plant.poses)


def test_live_the_ring_closes_over_an_agent_that_is_gone_and_opens_for_the_next_one() -> None:
    settings = ["formation.robots=4", "duration=1", "membership.patience=0.1"]
    run = MemoryRun(load("ring-16", settings))
    run.run(60.0, lambda: run.world.k == 10)
    run.kill_agent(2)
    run.run(60.0, lambda: bool(run.world.away))
    assert run.world.away == {2}
    assert run.world.closed_at == run.world.k
    run.run(60.0, lambda: run.world.k == 50)
    assert {robot: process.node._agent.hears for robot, process in run.agents.items() if process.node._agent}[3] == [1]
    run.start_agent(2)
    run.finish()
    assert not run.world.away
    texts = [event.text for event in run.world.events]
    left, joined = (
        texts.index(text) for text in ("robot 2 leaves the ring: robot 3 hears robot 1", "robot 2 joins the ring")
    )
    assert texts.index("agent 2 lost") < left < joined
