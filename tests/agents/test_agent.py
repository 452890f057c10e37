"""One robot's agent: whose plans it uses, what it does without them, and that it uses nothing it was not given."""

# mypy: disable-error-code="call-arg, no-any-return"
# (unpacked poses, numpy scalars and shapes; what strict typing of numpy makes of test arithmetic)

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from agents.agent import Agent
from agents.sending import Answer
from formation.arrays import FloatArray
from formation.faults import Fault
from formation.link_ids import LinkId
from formation.scenario.files import load
from formation.scenario.reshaping import change_of, reshaped
from formation.scenario.scenario import Scenario
from formation.unicycle import step
from network.codec import decode, encode
from network.fields import LARGEST
from network.messages import Command, Plan, Status
from tests import builders
from world.command_links import WATCHDOG
from world.world import World

TICK = 0.01


def agent(robot: int = 1, *settings_: str, name: str = "circle", episode: int = 0) -> Agent:
    return Agent(load(name, settings_), robot, episode=episode)


def plan(k: int, sender: int = 2, episode: int = 0, **changes: Any) -> Plan:
    values = {"pose": np.array([0.75, 0.0, math.pi / 2]), "inputs": np.tile([0.04, 0.05], (20, 1))}
    return builders.plan(sender, k, episode, **{**values, **changes})


def at_tick(agent: Agent, k: int, stamp: float, pose: FloatArray, speed: tuple[float, float] = (0.0, 0.0)) -> Answer:
    """The agent's answer to tick k, at which its pose is measured and its wheels have turned with `speed`."""
    everybody = np.tile(pose, (agent.size, 1))
    return agent.step(builders.tick(k, everybody, odometry=np.tile(speed, (agent.size, 1)), stamp=stamp))


def start(scenario: Scenario, robot: int) -> FloatArray:
    return scenario.start_poses()[robot - 1]


def answers(one: Agent, pose: FloatArray, ticks: range) -> list[Answer]:
    """Answers on consecutive ticks, with the robot held in one place."""
    return [at_tick(one, k, k * TICK, pose) for k in ticks]


def believed(one: Agent) -> int:
    """Number of the plan that it goes by; -1 for none."""
    held = one._receivers[0].belief.plan
    return -1 if held is None else held.seq


POSE = start(load("circle"), 1)


# ---------------------------------------------------------------- whose plans count


def test_a_plan_of_the_upstream_neighbour_is_believed() -> None:
    one = agent()
    one.receive(plan(0))
    command = at_tick(one, 1, TICK, POSE).command
    assert command.age == pytest.approx(TICK)
    assert believed(one) == 0
    assert one.counts().sent == one.counts().delivered == 1


@pytest.mark.parametrize(
    "stranger",
    [plan(0, episode=1), plan(0, sender=1), plan(0, sender=3), plan(0, sender=0)],
    ids=["another episode", "itself", "somebody else", "the world"],
)
def test_a_plan_of_another_epoch_or_sender_is_ignored(stranger: Any) -> None:
    one, alone = agent(), agent()
    one.receive(stranger)
    got, expected = at_tick(one, 1, TICK, POSE), at_tick(alone, 1, TICK, POSE)
    assert one.counts().sent == 0
    assert believed(one) == -1
    assert (got.command.v, got.command.omega) == (expected.command.v, expected.command.omega)
    assert got.command.age == pytest.approx(TICK)  # since the start of the episode


def test_an_agent_of_a_later_episode_uses_plans_of_that_episode() -> None:
    one = agent(episode=7)
    one.receive(plan(0, episode=0))
    one.receive(plan(0, episode=7))
    answer = at_tick(one, 1, TICK, POSE)
    assert one.counts().sent == 1
    assert answer.command.episode == 7
    assert answer.plan is not None
    assert answer.plan.episode == 7


def test_a_plan_that_was_there_before_is_ignored() -> None:
    one = agent()
    for k in (3, 3, 2, 4):
        one.receive(plan(k))
    assert one.counts().sent == 2
    assert one.heard == 4


def test_an_older_plan_that_arrives_later_is_counted_late_and_not_used() -> None:
    one = agent()
    one.set_faults({LinkId(2, 1): Fault(latency=0.5)})
    one.receive(plan(0))
    one.set_faults({})
    one.receive(plan(10))
    at_tick(one, 11, 0.11, POSE)
    assert believed(one) == 10
    command = at_tick(one, 60, 0.60, POSE).command
    assert one.counts().late == 1
    assert one.counts().delivered == 2
    assert believed(one) == 10
    assert command.age == pytest.approx(0.5)


def test_a_damaged_plan_is_counted_and_not_used() -> None:
    one, alone = agent(), agent()
    one.set_faults({LinkId(2, 1): Fault(corrupt=1.0)})
    for k in range(5):
        one.receive(plan(k))
        alone_answer, answer = at_tick(alone, k, k * TICK, POSE), at_tick(one, k, k * TICK, POSE)
        assert answer.command.v == alone_answer.command.v
    c = one.counts()
    assert (c.sent, c.delivered, c.corrupt) == (5, 5, 5)
    assert believed(one) == -1


def test_a_plan_that_is_late_is_not_used_before_it_has_arrived() -> None:
    one, alone = agent(), agent()
    one.set_faults({LinkId(2, 1): Fault(latency=0.05)})
    one.receive(plan(0))
    for k in range(5):
        assert at_tick(one, k, k * TICK, POSE).command.v == at_tick(alone, k, k * TICK, POSE).command.v
        assert believed(one) == -1
    command = at_tick(one, 5, 0.05, POSE).command
    assert believed(one) == 0
    assert command.age == pytest.approx(0.05)


def test_the_scenarios_own_link_holds_from_the_first_tick() -> None:
    one = agent(1, "link.latency=0.05")
    one.receive(plan(0))
    at_tick(one, 0, 0.0, POSE)
    assert one.counts().in_flight == 1


@given(st.floats(-LARGEST, LARGEST), st.floats(1e-300, LARGEST), st.sampled_from(["nash", "paper"]))
@settings(max_examples=40)
def test_any_valid_plan_of_a_neighbour_gives_finite_inputs_within_limits(
    number: Any, interval: Any, controller: Any
) -> None:
    one = agent(1, f"controller.name={controller}")
    wild = plan(0, pose=np.full(3, number), interval=interval, inputs=np.full((20, 2), -number))
    with np.errstate(all="ignore"):
        one.receive(decode(Plan, encode(wild)))
        command = at_tick(one, 1, TICK, POSE).command
    assert abs(command.v) <= 0.5
    assert abs(command.omega) <= 2.0


@pytest.mark.parametrize("steps", [1, 19, 21, 100])
def test_a_plan_of_another_horizon_does_no_harm(steps: Any) -> None:
    one = agent()
    one.receive(plan(0, inputs=np.ones((steps, 2))))
    command = at_tick(one, 1, TICK, POSE).command
    assert abs(command.v) <= 0.5


# ---------------------------------------------------------------- what it says


def test_a_command_and_a_plan_carry_tick_stamp_and_sender() -> None:
    one = agent(2)
    answer = at_tick(one, 37, 0.37, start(load("circle"), 2))
    for message in (answer.command, answer.plan):
        assert message is not None
        assert (message.sender, message.seq, message.stamp, message.episode) == (2, 37, 0.37, 0)
    assert answer.command.planned
    assert answer.plan is not None
    np.testing.assert_array_equal(answer.plan.pose, start(load("circle"), 2))
    assert answer.plan.inputs.shape == (20, 2)
    assert (answer.command.v, answer.command.omega) == tuple(answer.plan.inputs[0])
    assert decode(Command, encode(answer.command)) == answer.command


def test_between_plans_the_plans_own_inputs_are_applied() -> None:
    one = agent(1, "controller.plan_every=15", name="figure8")
    said = answers(one, start(load("figure8"), 1), range(30))
    assert [k for k, answer in enumerate(said) if answer.plan is not None] == [0, 15]
    first = said[0].plan
    assert first is not None
    for k, answer in enumerate(said[:15]):
        assert (answer.command.v, answer.command.omega) == tuple(first.inputs[k // 10])
        assert answer.command.planned == (k == 0)
    assert tuple(first.inputs[0]) != tuple(first.inputs[1])


def test_who_starts_between_two_planning_ticks_plans_at_once() -> None:
    one = agent(1, "controller.plan_every=10")
    assert at_tick(one, 7, 0.07, POSE).plan is not None
    assert at_tick(one, 8, 0.08, POSE).plan is None
    assert at_tick(one, 10, 0.10, POSE).plan is not None


def test_a_status_tells_link_age_and_counts_and_goes_over_the_wire() -> None:
    one = agent()
    one.receive(plan(0))
    sent = at_tick(one, 3, 0.03, POSE).plan
    assert sent is not None
    said = one.status(3, 0.03, missed=4, rejected=5, pid=6)
    assert (said.sender, said.link) == (1, LinkId(2, 1))
    answered = one.observation
    assert answered is not None
    assert said.believes is not None
    np.testing.assert_array_equal(said.believes.inputs, answered.upstream.inputs)
    assert said.plan is not None
    assert said.plan.begins == 0.03
    assert said.plan_bytes == len(encode(sent))
    assert said.age == pytest.approx(0.03)
    assert (said.missed, said.rejected, said.pid) == (4, 5, 6)
    assert said.solve > 0.0
    assert said.gap >= 0.0
    assert encode(decode(Status, encode(said))) == encode(said)


def test_the_answer_depends_on_nothing_but_what_it_was_given() -> None:
    first, second = agent(), agent()
    for one in (first, second):
        one.receive(plan(0))
    for k in range(1, 6):
        a, b = at_tick(first, k, k * TICK, POSE), at_tick(second, k, k * TICK, POSE)
        assert (a.command.v, a.command.omega) == (b.command.v, b.command.omega)
        assert a.plan is not None
        assert b.plan is not None
        np.testing.assert_array_equal(a.plan.inputs, b.plan.inputs)


# ---------------------------------------------------------------- where it is


def test_who_never_learned_where_it_is_does_not_move_and_says_no_plan() -> None:
    one = agent()
    one.set_faults({LinkId(0, 1): Fault(cut=True)})
    one.receive(plan(0))
    for answer in answers(one, POSE, range(1, 50)):
        assert (answer.command.v, answer.command.omega) == (0.0, 0.0)
        assert answer.plan is None
        assert not answer.command.planned


def test_with_late_poses_it_dead_reckons_along_its_odometry() -> None:
    one = agent()
    pose = tuple(POSE)
    truth, speed = [pose], (0.0, 0.0)
    one.set_faults({LinkId(0, 1): Fault(latency=0.2)})
    for k in range(100):
        answer = at_tick(one, k, k * TICK, np.array(pose), speed)
        if k < 20:
            assert answer.plan is None  # the first pose is still on its way
        else:
            # It has the pose of 0.2 s ago; carried along what it did since, that is where it is now.
            assert answer.plan is not None
            np.testing.assert_allclose(answer.plan.pose, pose, atol=1e-12)
        speed = answer.command.v, answer.command.omega
        pose = step(*pose, *speed, TICK)
        truth.append(pose)
    assert math.dist(truth[-1][:2], truth[0][:2]) > 0.01


def test_when_poses_are_cut_it_goes_on_by_dead_reckoning_alone() -> None:
    one, pose, speed = agent(), tuple(POSE), (0.0, 0.0)
    for k in range(60):
        if k == 10:
            one.set_faults({LinkId(0, 1): Fault(cut=True)})
        measured = np.array(pose) if k < 10 else np.array([99.0, 99.0, 0.0])  # what it is not told does not matter
        answer = at_tick(one, k, k * TICK, measured, speed)
        assert answer.plan is not None
        np.testing.assert_allclose(answer.plan.pose, pose, atol=1e-12)
        speed = answer.command.v, answer.command.omega
        pose = step(*pose, *speed, TICK)


def test_once_the_pose_link_is_mended_it_believes_what_it_measures() -> None:
    one = agent()
    one.set_faults({LinkId(0, 1): Fault(cut=True)})
    answers(one, POSE, range(5))
    one.set_faults({})
    answer = at_tick(one, 5, 0.05, POSE)
    assert answer.plan is not None
    np.testing.assert_array_equal(answer.plan.pose, POSE)


def test_a_damaged_pose_is_not_believed() -> None:
    one = agent()
    one.set_faults({LinkId(0, 1): Fault(corrupt=1.0)})
    assert at_tick(one, 0, 0.0, POSE).plan is None


def test_an_agent_whose_formation_changes_before_the_first_tick_begins_in_that_one() -> None:
    """Whether it was there already when that was ordered, or came after: what it believes at the start is the same."""
    scenario = load("ring-16", ["formation.robots=4", "bodies=camera"])
    new = reshaped(scenario, [change_of(scenario, 0.0, shape="line", spacing=0.2)])
    told, fresh = Agent(scenario, 2), Agent(new, 2)
    told.reshape(new, 0)
    pose = new.start_poses()[1]
    for k in range(3):
        one, other = at_tick(told, k, k * TICK, pose), at_tick(fresh, k, k * TICK, pose)
        assert one.plan is not None
        assert other.plan is not None
        np.testing.assert_array_equal(one.plan.pose, other.plan.pose)
        np.testing.assert_array_equal(one.plan.inputs, other.plan.inputs)
    assert not np.array_equal(
        Agent(scenario, 2)._estimator.memory.real,  # type: ignore[attr-defined]
        Agent(new, 2)._estimator.memory.real,  # type: ignore[attr-defined]
    ), "the two begin differently"


def test_a_robot_without_poses_stands_still_in_the_world_as_well() -> None:
    scenario = load("circle", ['faults=[{link="world->1", cut=true}]'])
    world = World(scenario)
    agents = {i: Agent(scenario, i) for i in world.robots}
    before = world.plant.poses.copy()
    for _ in range(50):
        tick = world.tick()
        for one in agents.values():
            one.set_faults(world.faults.table)
        world.advance({i: one.step(tick).command for i, one in agents.items()})
    np.testing.assert_array_equal(world.plant.poses[0], before[0])
    assert math.dist(world.plant.poses[1, :2], before[1, :2]) > 0.005
    assert world.now > WATCHDOG
    # it answers every tick, with zero: it is not the watchdog that holds it
    assert not [event for event in world.events if event.kind == "watchdog"]
