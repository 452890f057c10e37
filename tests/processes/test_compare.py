"""The ghost beside a live run of processes: idle until requested, then equal to the live episode to the last bit."""

import os
import signal
import time
from collections.abc import Callable

import numpy as np
import pytest

from network import topics
from network.bus import Sample
from network.codec import decode
from network.messages import Ghost, State
from network.zenoh_bus import ZenohBus
from runtime.run_registry import find
from tests.processes.live import Up, echelon, wait_for

pytestmark = pytest.mark.processes
Start = Callable[..., Up]


class Ears:
    """Hears states and ghosts of the run, and pairs those of the same stamp."""

    def __init__(self, session: ZenohBus) -> None:
        self._session = session
        self.states: dict[tuple[int, float], State] = {}
        self.ghosts: dict[tuple[int, float], Ghost] = {}
        session.subscribe(topics.state(session.run))
        session.subscribe(topics.ghost(session.run))

    def listen(self) -> None:
        while not self._session.inbox.empty():
            item = self._session.inbox.get()
            if isinstance(item, Sample) and item.key.endswith("/state"):
                state = decode(State, item.payload)
                self.states[state.episode, state.stamp] = state
            elif isinstance(item, Sample):
                ghost = decode(Ghost, item.payload)
                self.ghosts[ghost.episode, ghost.stamp] = ghost

    def pairs(self, controller: str, episode: int | None = None) -> list[tuple[State, Ghost]]:
        self.listen()
        return [
            (self.states[key], ghost)
            for key, ghost in self.ghosts.items()
            if key in self.states and ghost.controller == controller and episode in (None, key[0])
        ]


def test_the_ghost_of_the_live_controller_is_the_live_episode_through_faults_and_resets(up: Start) -> None:
    run = up("triangle-circle", "--no-dashboard", "--set", "noise.slip=0.1", "--set", "link.loss=0.2")
    run.running()
    endpoint = find("test").endpoint
    with ZenohBus(endpoint, "test") as session:
        ears = Ears(session)
        echelon("fault", "set", "--link", "1->2", "--latency", "200ms")
        time.sleep(1.0)
        ears.listen()
        assert not ears.ghosts  # nobody has asked for one
        echelon("control", "compare", "nash")
        assert run.status()["compare"] == "nash"
        wait_for(lambda: ears.pairs("nash"))
        echelon("fault", "set", "--link", "2->3", "--cut", "--for", "1s")
        echelon("fault", "preset", "bursty", "--link", "3->1")
        end = max(ears.states)[1] + 3.0
        wait_for(lambda: any(state.stamp > end for state, _ in ears.pairs("nash")))
        episode = run.status()["episode"]
        echelon("control", "reset")
        wait_for(lambda: [pair for pair in ears.pairs("nash", episode + 1) if pair[0].stamp > 1.0])
        pairs = ears.pairs("nash")
        assert len({state.revision for state, _ in pairs}) >= 4
        for state, ghost in pairs:
            np.testing.assert_array_equal(ghost.poses, state.poses)
            np.testing.assert_array_equal(ghost.angle_errors, state.angle_errors)

        os.kill(run.pid("ghost"), signal.SIGKILL)  # it comes back and catches up
        seen = len(ears.pairs("nash"))
        wait_for(lambda: len(ears.pairs("nash")) > seen + 20)

        echelon("control", "scenario", "figure8")
        echelon("control", "compare", "leader_follower")
        wait_for(lambda: [p for p in ears.pairs("leader_follower", episode + 2) if p[0].stamp > 1.0])
        state, ghost = max(ears.pairs("leader_follower", episode + 2), key=lambda pair: pair[0].stamp)
        assert ghost.poses.shape == state.poses.shape == (2, 3)
        assert np.abs(ghost.poses - state.poses).max() > 1e-4

        echelon("control", "compare", "off")
        time.sleep(0.5)
        ears.listen()
        said = len(ears.ghosts)
        time.sleep(0.5)
        ears.listen()
        assert len(ears.ghosts) == said
    run.end()
    assert "ghost ended (signal 9): starting it again" in run.text()
