"""Laws of a crew: what its agents say goes out as it would of each alone, but may share packets."""

from agents.crew import Crew
from agents.node import AgentNode
from formation.scenario.files import load
from network import topics
from network.bus import Action, Announce, Publish, Response, Sample
from network.codec import encode
from network.control import GetSetup, request
from network.messages import Command, Plan
from network.values import Mode
from world.world import World


def begun(node: Crew | AgentNode, mode: Mode = "lockstep") -> tuple[World, list[Action]]:
    """A world, and what the node does when it hears the Setup and the first tick."""
    world = World(load("triangle-circle"), episode=3, mode=mode)
    world.live = {1, 2, 3}
    node.feed([], 0.0)
    actions = node.feed([Response(request(GetSetup()), encode(world.setup()))], 0.1)
    return world, actions + node.feed([Sample(topics.tick("x"), encode(world.tick()))], 0.2)


def test_what_a_crew_says_may_share_packets_and_what_an_agent_alone_says_may_not() -> None:
    for mode in ("lockstep", "realtime"):
        _, alone = begun(AgentNode("x", 1), mode)
        _, crew = begun(Crew("x", (1, 2)), mode)
        assert {action.packed for action in alone if isinstance(action, Announce)} == {False}
        announced = [action for action in crew if isinstance(action, Announce)]
        assert {action.key for action in announced} == {topic.key("x", i) for topic in topics.OF_AGENTS for i in (1, 2)}
        assert {action.packed for action in announced} == {True}
        assert {action.reliable for action in announced} == {mode == "lockstep"}


def test_a_crew_says_at_a_tick_what_its_agents_say_alone() -> None:
    def said(node: Crew | AgentNode) -> dict[str, Plan | Command]:
        _, actions = begun(node)
        sent = [action for action in actions if isinstance(action, Publish)]
        return {one.key: one.message for one in sent if isinstance(one.message, Plan | Command)}

    together, alone = said(Crew("x", (1, 2))), {**said(AgentNode("x", 1)), **said(AgentNode("x", 2))}
    assert (
        together.keys()
        == alone.keys()
        == {topics.plan("x", i) for i in (1, 2)} | {topics.command("x", i) for i in (1, 2)}
    )
    for key, message in together.items():
        other = alone[key]
        if isinstance(message, Plan):
            assert encode(message) == encode(other)
        else:
            assert isinstance(other, Command)
            assert (message.v, message.omega, message.seq) == (other.v, other.omega, other.seq)


def test_what_shares_packets_waits_in_one_queue() -> None:
    """Zenoh has a queue for each priority and packs what is in one: a run's mode decides of all that an agent says."""
    assert len({topic.reliable for topic in topics.OF_AGENTS}) == 1
