"""The ghost's part in the protocol of a run, without I/O and without a clock: arrivals and a time in, actions out.

It reads the newest state only, so that it never delays the run: a ghost that cannot keep pace falls behind, and catches
up when it can. It never simulates beyond a state of which it does not know the faults and the orders.
"""

from collections.abc import Iterable

from pydantic import ValidationError

from agents.controllers.own import check_loaded
from formation.errors import EchelonError
from formation.scenario.registry import register_unloaded
from formation.scenario.scenario import Scenario
from network import topics
from network.bus import Action, Ask, Incoming, Publish, Reject, Response, Sample
from network.codec import decode
from network.control import GetOrders, GetSetup, Operation, Orders, request
from network.messages import State
from network.requests import Reply, Request, Setup
from runtime.ghost.shadow import Shadow

IDLE_SECONDS = 0.25
"""Between two looks without a comparison [s]."""
WATCH_SECONDS = 0.01
"""Between two looks during a comparison [s]."""
RETRY_SECONDS = 0.5
"""A request that is not answered for this long is sent again [s]."""
SHOWN_SECONDS, SHOWN_INTERVAL = 45.0, 0.1
"""A ghost that catches up publishes this many of the missed seconds, in such steps [s]."""


class GhostNode:
    """Simulates a ghost beside a run while a comparison is requested.

    What it asks for follows from the newest state: nothing without a comparison; the Setup if the ghost is of another
    episode or controller; the tables of faults and the driver's orders if there are more of them; else it follows.
    """

    def __init__(self, run: str) -> None:
        self._key = topics.ghost(run)
        self._shadow: Shadow | None = None
        self._state: State | None = None
        self._revision = -1
        """Up to which the faults are known; of the driver's orders the ghost itself knows how many it has."""
        self._asked_revision = -1
        self._ask_at = 0.0
        self._published = 0
        """seq of the newest state that a ghost was published for."""
        self._late = False
        """Whether there is more to catch up with than one shown step."""
        self._actions: list[Action] = []

    @property
    def patience(self) -> float:
        """Feed it again after this long [s], if nothing arrives before."""
        if self.behind:
            return 0.0
        return IDLE_SECONDS if self._state is None or not self._state.compare else WATCH_SECONDS

    @property
    def behind(self) -> bool:
        """Whether there are ticks to simulate now: then call `step`, and `feed` again from time to time."""
        shadow, state = self._following
        return shadow is not None and state is not None and not shadow.finished and shadow.k < self._goal(shadow, state)

    @property
    def _following(self) -> tuple[Shadow | None, State | None]:
        """Ghost and newest state, if the ghost knows everything up to it."""
        shadow, state = self._shadow, self._state
        if shadow is None or state is None or not self._fits(shadow, state) or self._lacks(shadow, state):
            return None, state
        return shadow, state

    @staticmethod
    def _fits(shadow: Shadow, state: State) -> bool:
        return (shadow.episode, shadow.controller) == (state.episode, state.compare)

    def _lacks(self, shadow: Shadow, state: State) -> bool:
        """Whether there are faults or orders up to the state that the ghost does not know."""
        behind = shadow.drives_known < state.driving.orders or shadow.interventions_known < state.interventions
        return self._revision != state.revision or behind

    @staticmethod
    def _goal(shadow: Shadow, state: State) -> int:
        return shadow.tick_at(state.stamp)

    def feed(self, arrivals: Iterable[Incoming], now: float) -> list[Action]:
        """Take what has arrived.

        Args:
            arrivals: oldest first.
            now: monotonic time [s].

        Returns:
            What is to be done, in order.
        """
        for item in arrivals:
            try:
                if isinstance(item, Sample):
                    self._state = decode(State, item.payload)
                elif isinstance(item, Response):
                    self._receive(item)
            except (EchelonError, ValidationError) as error:
                self._actions.append(Reject("state" if isinstance(item, Sample) else "control", str(error)))
        self._ask(now)
        self._look()
        actions, self._actions = self._actions, []
        return actions

    def step(self) -> list[Action]:
        """Simulate one tick, if there is one to simulate; what is to be done then."""
        shadow, state = self._following
        if shadow is None or state is None or not self.behind:
            return []
        shadow.step()
        goal, every = self._goal(shadow, state), self._every(shadow)
        shown = shadow.k >= goal - shadow.tick_at(SHOWN_SECONDS) and shadow.k % every == 0
        if shadow.k == goal:
            self._reach(shadow, state)
        elif self._late and shown:
            self._publish(shadow)
        actions, self._actions = self._actions, []
        return actions

    # ------------------------------------------------------------------ scenario and faults

    def _ask(self, now: float) -> None:
        """Ask for what is missing."""
        shadow, state = self._shadow, self._state
        if state is None or not state.compare:
            self._shadow = None
            return
        wanted: Operation
        if shadow is None or not self._fits(shadow, state):
            wanted = GetSetup()
        elif self._lacks(shadow, state):
            wanted = GetOrders(
                tables=shadow.tables_known, drives=shadow.drives_known, interventions=shadow.interventions_known
            )
        else:
            return
        if now >= self._ask_at:
            self._ask_at = now + RETRY_SECONDS
            self._asked_revision = state.revision
            self._actions.append(Ask(request(wanted)))

    def _receive(self, response: Response) -> None:
        """An answer; one that is not for the question of now is of no use."""
        state, shadow = self._state, self._shadow
        if state is None or not state.compare:
            return
        needs_setup = shadow is None or not self._fits(shadow, state)
        if response.request.operation == request(GetSetup()).operation:
            setup = decode(Setup, response.payload)
            if needs_setup and setup.episode == state.episode:
                register_unloaded(setup.user_code)
                check_loaded(setup.user_code, state.compare)
                scenario = Scenario.model_validate_json(setup.scenario)
                self._shadow = Shadow(scenario, state.compare, state.episode)
                self._revision, self._ask_at = -1, 0.0
        elif shadow is not None and not needs_setup:
            self._learn(shadow, response.request, decode(Reply, response.payload))

    def _learn(self, shadow: Shadow, asked: Request, reply: Reply) -> None:
        if not reply.ok:
            raise EchelonError(reply.reason)
        told = Orders.model_validate(reply.value)
        known = {
            "tables": shadow.tables_known,
            "drives": shadow.drives_known,
            "interventions": shadow.interventions_known,
        }
        if told.episode != shadow.episode or asked.arguments != known:
            return
        if not any(known.values()):
            shadow.resume_at(told.resumed)
        shadow.learn(told.tables, told.drives, told.interventions)
        self._ask_at = 0.0
        if not told.tables or shadow.tables_known >= told.changes:
            self._revision = self._asked_revision

    # ------------------------------------------------------------------ what is shown

    @staticmethod
    def _every(shadow: Shadow) -> int:
        return max(1, shadow.tick_at(SHOWN_INTERVAL))

    def _look(self) -> None:
        shadow, state = self._following
        if shadow is None or state is None:
            return
        goal = self._goal(shadow, state)
        self._late = goal - shadow.k > self._every(shadow)
        if shadow.k == goal:
            self._reach(shadow, state)
        elif shadow.k < goal - shadow.tick_at(SHOWN_SECONDS):
            self._publish(shadow)  # a sign of life

    def _reach(self, shadow: Shadow, state: State) -> None:
        """It is where the live run was at the state: publish that once."""
        if self._published != state.seq:
            self._published = state.seq
            self._publish(shadow)

    def _publish(self, shadow: Shadow) -> None:
        self._actions.append(Publish(self._key, shadow.message(self._published)))
