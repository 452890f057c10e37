"""The ghost's process: keep up with the live episode, and publish a Ghost for every State of the world.

It reads the newest state only, so that it never delays the run: a ghost that cannot keep pace falls behind,
and catches up when it can.
"""

from time import monotonic, sleep

from pydantic import ValidationError

from formation.errors import EchelonError, WireError
from formation.scenario.scenario import Scenario
from network import topics
from network.codec import decode
from network.control import FaultTables, GetFaults
from network.lifetime import Lifetime
from network.messages import State
from network.throttled_log import ThrottledLog
from network.zenoh_bus import ZenohBus
from runtime.ghost.shadow import Shadow

IDLE_SECONDS = 0.25
"""Period of the loop without a comparison [s]."""
WATCH_SECONDS = 0.01
"""Period of the loop during a comparison [s]."""
RETRY_SECONDS = 0.5
"""Pause after the world did not answer [s]."""
TURN_SECONDS = 0.1
"""Longest time spent on simulating before the newest state is read again [s]."""
SHOWN_SECONDS, SHOWN_INTERVAL = 45.0, 0.1
"""A ghost that catches up publishes this many of the missed seconds, in such steps [s]."""


class GhostNode:
    """Simulates a ghost beside a run while a comparison is requested."""

    def __init__(self, session: ZenohBus, lifetime: Lifetime) -> None:
        self._session, self._lifetime = session, lifetime
        self._rejects = ThrottledLog()
        self._shadow: Shadow | None = None
        self._state: State | None = None
        self._said = 0
        self._told_revision = -1
        self._states = session.keep(topics.state(session.run), 1)
        self._key = topics.ghost(session.run)
        session.announce(self._key)
        session.appear("ghost")

    def run(self) -> None:
        """Run until the process is asked to end."""
        while not self._lifetime.over:
            sleep(self._turn())

    def _turn(self) -> float:
        """One turn of the loop; returns the pause until the next [s]."""
        for sample in self._states.take():
            try:
                self._state = decode(State, sample.payload)
            except WireError as error:
                self._rejects.add("state", error)
        state = self._state
        if state is None or not state.compare:
            self._shadow = None
            return IDLE_SECONDS
        try:
            shadow = self._shadow_of(state)
        except (EchelonError, ValidationError) as error:
            self._rejects.add("control", error)
            shadow = None
        if shadow is None:
            return RETRY_SECONDS
        return 0.0 if self._follow(shadow, state) else WATCH_SECONDS

    # ------------------------------------------------------------------ scenario and faults

    def _shadow_of(self, state: State) -> Shadow | None:
        """The ghost of this episode, with the faults up to this state; None if the world does not answer."""
        shadow = self._shadow
        if shadow is None or (shadow.episode, shadow.controller) != (state.episode, state.compare):
            setup = self._session.setup()
            if setup is None or setup.episode != state.episode:
                return None
            scenario = Scenario.model_validate_json(setup.scenario)
            shadow = self._shadow = Shadow(scenario, state.compare, state.episode)
            self._told_revision = -1
        if self._told_revision != state.revision:
            if not self._ask_faults(shadow):
                return None
            self._told_revision = state.revision
        return shadow

    def _ask_faults(self, shadow: Shadow) -> bool:
        """Fetch every fault table so far. False if the world does not answer."""
        while True:
            reply = self._session.ask(GetFaults(known=shadow.known))
            if reply is None:
                return False
            if not reply.ok:
                raise EchelonError(reply.reason)
            told = FaultTables.model_validate(reply.value)
            if told.episode != shadow.episode:
                return False
            shadow.learn(told.tables)
            if not told.tables or shadow.known >= told.changes:
                return True

    # ------------------------------------------------------------------ simulating

    def _follow(self, shadow: Shadow, state: State) -> bool:
        """Simulate up to the state, for one turn at most; returns whether ticks are left to simulate at once."""
        goal = shadow.tick_at(state.stamp)
        shown = goal - shadow.tick_at(SHOWN_SECONDS)
        every = max(1, shadow.tick_at(SHOWN_INTERVAL))
        until = monotonic() + TURN_SECONDS
        late = goal - shadow.k > every
        while shadow.k < goal and not (shadow.finished or self._lifetime.over):
            shadow.step()
            if late and shadow.k >= shown and shadow.k % every == 0:
                self._say(shadow)
            if monotonic() > until:
                break
        if shadow.k == goal:
            if self._said != state.seq:
                self._said = state.seq
                self._say(shadow)
            return False
        if shadow.k < shown:
            self._say(shadow)  # a sign of life
        return not shadow.finished

    def _say(self, shadow: Shadow) -> None:
        self._session.publish(self._key, shadow.message(self._said))
