"""Laws of the ghost's node: whatever the bus does, it is where the live run was, and it follows again afterwards."""

from typing import Any

from hypothesis import given, settings
from hypothesis import strategies as st

from formation.link_ids import LinkId
from formation.scenario.files import load
from network import topics
from network.bus import Sample, perform
from network.codec import decode
from network.control import Compare, Reset, SetFault, Speed
from network.messages import Ghost, State
from network.throttled_log import ThrottledLog
from runtime.ghost.node import GhostNode
from tests.memory_run import MemoryRun, Weather

SETTINGS = {"duration": 1.5, "noise": {"slip": 0.2, "position": 0.001}, "link": {"latency": 0.02, "loss": 0.2}}


def follow(run: MemoryRun, seconds: float, turn: Any) -> None:
    """Let the run go on, with the ghost's process beside it."""
    end = run.hub.now + seconds
    while run.hub.now < end:
        run.run(0.02)
        turn()


@settings(max_examples=15, deadline=None, derandomize=True, database=None)
@given(
    st.builds(
        Weather,
        seed=st.integers(0, 2**16),
        lost=st.sampled_from([0.0, 0.3]),
        doubled=st.sampled_from([0.0, 0.3]),
        delayed=st.sampled_from([0.0, 0.3]),
        longest=st.sampled_from([0.01, 0.2]),
        until=st.just(2000),
    ),
    st.booleans(),
    st.booleans(),
)
def test_the_ghost_of_the_live_controller_is_where_the_live_run_was(weather: Weather, fault: bool, reset: bool) -> None:
    run = MemoryRun(load("triangle-circle", SETTINGS), weather)
    run.ask_until(Speed(speed=1.0), lambda: run.node._rate.speed == 1.0)
    bus, node, log = run.hub.join(run.user.run, "ghost"), GhostNode(run.user.run), ThrottledLog()
    states = bus.keep(topics.state(bus.run), 1)
    bus.announce(topics.ghost(bus.run))
    run.user.subscribe(topics.state(bus.run))
    run.user.subscribe(topics.ghost(bus.run))
    live: dict[tuple[int, float], bytes] = {}
    ghosts: dict[tuple[int, float], bytes] = {}

    def turn() -> None:
        perform(bus, node.feed([*states.take(), *bus.arrivals()], run.hub.now), log)
        while node.behind:
            perform(bus, node.step(), log)
        for item in run.user.arrivals():
            if isinstance(item, Sample):
                kind, into = (Ghost, ghosts) if item.key == topics.ghost(bus.run) else (State, live)
                message: Any = decode(kind, item.payload)
                into[message.episode, message.stamp] = message.poses.tobytes()

    run.ask_until(Compare(controller="nash"), lambda: run.node._control.compare == "nash")
    follow(run, 0.5, turn)
    if fault:
        before = run.world.revision
        run.ask_until(SetFault(link="1->2", changes={"loss": 0.9}), lambda: run.world.revision != before)
    if reset:
        episode = run.world.episode
        run.ask_until(Reset(), lambda: run.world.episode != episode)
    follow(run, 1.0, turn)
    run.hub.fate = Weather()
    follow(run, 4.0, turn)
    common = live.keys() & ghosts.keys()
    assert all(live[key] == ghosts[key] for key in common)
    assert (run.world.episode, run.world.now) in common, "it follows again"
    assert LinkId.parse("1->2") in run.world.faults.table or not fault
