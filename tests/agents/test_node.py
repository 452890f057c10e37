"""Laws of an agent's node: what it is told falsely it unlearns from the world."""

from dataclasses import replace

from agents.node import ASK_SECONDS, AgentNode
from formation.scenario.files import load
from network import topics
from network.bus import Action, Announce, Appear, Ask, Publish, Response, Sample
from network.codec import encode
from network.control import GetSetup, request
from network.requests import Setup
from network.values import Mode
from world.world import World


def response(setup: Setup) -> Response:
    return Response(request(GetSetup()), encode(setup))


def tick(world: World) -> Sample:
    return Sample(topics.tick("x"), encode(world.tick()))


def commands(actions: list[Action]) -> int:
    return sum(isinstance(action, Publish) and action.key == topics.command("x", 1) for action in actions)


def world_with(node: AgentNode, mode: Mode = "lockstep") -> tuple[World, list[Action]]:
    world = World(load("triangle-circle"), episode=3, mode=mode)
    world.live = {1, 2, 3}
    node.feed([], 0.0)
    return world, node.feed([response(world.setup())], 0.1)


def test_what_an_agent_sends_waits_for_slow_receivers_in_lockstep_only() -> None:
    for mode in ("lockstep", "realtime"):
        _, actions = world_with(AgentNode("x", 1), mode)
        announced = [action for action in actions if isinstance(action, Announce)]
        assert {action.key for action in announced} == {topic.key("x", 1) for topic in topics.OF_AGENTS}
        assert {action.reliable for action in announced} == {mode == "lockstep"}
        assert [type(action) for action in actions[-2:]] == [Announce, Appear]  # seen only when it can be heard


def test_a_setup_that_was_never_the_worlds_is_given_up_for_the_worlds() -> None:
    node = AgentNode("x", 1)
    world, _ = world_with(node)
    node.feed([response(replace(world.setup(), revision=10**6, stamp=1e6))], 0.2)
    actions = node.feed([tick(world)], 1.0)
    assert commands(actions) == 0
    assert [action.request.operation for action in actions if isinstance(action, Ask)] == ["setup"]
    actions = node.feed([response(world.setup())], 1.0 + ASK_SECONDS)
    actions += node.feed([tick(world)], 1.1 + ASK_SECONDS)
    assert commands(actions) >= 1


def test_a_false_setup_asked_for_by_the_tick_that_the_world_waits_with_is_given_up_too() -> None:
    node = AgentNode("x", 1)
    world, _ = world_with(node)
    waits = Sample(topics.tick("x"), encode(replace(world.tick(), revision=1)))
    true = replace(world.setup(), revision=1)
    node.feed([waits], 0.2)
    node.feed([response(replace(true, revision=10**6, stamp=1e6))], 0.3)
    actions = node.feed([waits], 1.0)  # the world repeats it, for it lacks an answer
    assert [action.request.operation for action in actions if isinstance(action, Ask)] == ["setup"]
    assert commands(node.feed([response(true)], 1.1) + node.feed([waits], 1.2)) >= 1


def test_an_agent_is_woken_for_a_plan_only_while_it_waits_for_one() -> None:
    node = AgentNode("x", 1)
    world, _ = world_with(node)
    other = AgentNode("x", node._agent.upstream if node._agent else 0)
    other.feed([], 0.0)
    other.feed([response(world.setup())], 0.1)
    plan = next(
        Sample(action.key, encode(action.message))
        for action in other.feed([tick(world)], 0.2)
        if isinstance(action, Publish) and action.key.endswith("/plan")
    )
    assert commands(node.feed([tick(world)], 0.2)) == 1
    assert node.enough > 1
    later = replace(world.tick(), seq=1, stamp=0.01, planned=[1, 2, 3])
    assert commands(node.feed([Sample(topics.tick("x"), encode(later))], 0.3)) == 0
    assert node.enough == 1
    assert commands(node.feed([plan], 0.4)) == 1
    assert node.enough > 1


def test_an_older_setup_that_arrives_late_changes_nothing() -> None:
    node = AgentNode("x", 1)
    world, _ = world_with(node)
    old = world.setup()
    node.feed([response(replace(old, revision=old.revision + 1))], 0.2)
    node.feed([response(old)], 0.3)
    newer = replace(world.tick(), revision=old.revision + 1)
    assert commands(node.feed([Sample(topics.tick("x"), encode(newer))], 0.4)) == 1
