"""An agent's process: drain the inbox, think, publish.

It answers a tick of a lockstep run only when it holds its upstream neighbour's plan of the tick before, and never uses
a plan of the same tick: the result then does not depend on which process is faster.
"""

import os
from collections import deque
from queue import Empty
from time import monotonic, sleep

from pydantic import ValidationError

from agents.agent import Agent, Answer
from formation.errors import WireError
from formation.scenario.scenario import Scenario
from network import topics
from network.bus import Sample
from network.codec import decode
from network.lifetime import Lifetime
from network.messages import WORLD, Plan, Tick
from network.throttled_log import ThrottledLog
from network.zenoh_bus import ZenohBus

STATUS_INTERVAL = 0.1
"""Wall-clock time between two statuses [s]."""
RETRY_SECONDS = 0.2
"""Between two tries to hear from the world."""
MAX_AHEAD, MAX_TICKS_AHEAD = 1.0, 10
"""A plan may be stamped so far ahead of the newest tick [s], or by so many ticks."""
KEPT_PLANS = 256
"""Plans that wait for their tick; older ones go first."""


class AgentNode:
    """Keeps the agent of one robot in touch with the world and its neighbour."""

    def __init__(self, session: ZenohBus, robot: int, lifetime: Lifetime) -> None:
        self._session, self._robot, self._lifetime = session, robot, lifetime
        self._rejects = ThrottledLog()
        self._agent: Agent | None = None
        self._setup: tuple[int, int] | None = None  # episode and revision
        self._lockstep, self._size = True, 0
        self._listening_to: str | None = None
        self._plans: deque[Plan] = deque(maxlen=KEPT_PLANS)
        self._tick: Tick | None = None
        self._last_tick: Tick | None = None
        self._repeat = False
        self._answers: deque[Answer] = deque(maxlen=2)
        self._answered = -1
        self._missed = 0
        self._status_due = 0.0
        run = session.run
        self._keys = {word: key(run, robot) for word, key in _WORDS.items()}
        for key in self._keys.values():
            session.announce(key, reliable=True)
        session.subscribe(topics.tick(run))

    def run(self) -> None:
        """Until told to end."""
        while not (self._learn() or self._lifetime.over):
            sleep(RETRY_SECONDS)
        self._session.appear("agent", self._robot)
        inbox = self._session.inbox
        while not self._lifetime.over:
            try:
                item = inbox.get(timeout=0.5)
                while True:
                    if isinstance(item, Sample):
                        self._take(item)
                    item = inbox.get_nowait()
            except Empty:
                pass
            if self._tick is not None:
                self._meet(self._tick)

    def _take(self, sample: Sample) -> None:
        try:
            if sample.key.endswith("/tick"):
                tick = decode(Tick, sample.payload)
                if tick.sender != WORLD:
                    raise WireError(f"expected the world's tick; got one of {tick.sender}")
                newest = self._last_tick
                self._repeat |= newest is not None and (tick.episode, tick.seq) == (newest.episode, newest.seq)
                if newest is None or tick.episode != newest.episode or tick.seq >= newest.seq:
                    self._tick = self._last_tick = tick
                return
            plan = decode(Plan, sample.payload)
            if plan.sender != topics.robot_of(sample.key):
                raise WireError(f"expected the sender named in the key; got {plan.sender}")
            now = self._last_tick
            early = now is not None and plan.episode == now.episode and plan.seq > now.seq + MAX_TICKS_AHEAD
            if now is not None and early and plan.stamp > now.stamp + MAX_AHEAD:
                raise WireError(f"expected a stamp up to {now.stamp:g} s; got {plan.stamp:g} s")
            self._plans.append(plan)
        except WireError as error:
            self._rejects.add(sample.key, error)

    def _meet(self, tick: Tick) -> None:
        """Answer the tick if it can be answered now; if not, it is looked at again when something comes in."""
        if self._setup != (tick.episode, tick.revision):
            self._learn()
            if self._setup != (tick.episode, tick.revision):
                return
        if self._repeat and self._lockstep:  # the world says it again: something was lost on the way
            for answer in self._answers:
                self._say(answer)
        self._repeat = False
        agent = self._agent
        if len(tick.poses) != self._size:
            self._rejects.add("tick", f"expected {self._size} poses; got {len(tick.poses)}")
            self._tick = None
            return
        if agent is None or tick.seq <= self._answered:  # not a robot of this scenario, or nothing new
            self._tick = None
            return
        self._hear(agent, tick)
        if self._lockstep and agent.upstream in tick.planned and agent.heard < tick.seq - 1:
            return
        self._tick = None
        if not self._lockstep and self._answered >= 0:
            self._missed += tick.seq - self._answered - 1
        answer = agent.step(tick.seq, tick.stamp, tick.poses[self._robot - 1])
        self._answered = tick.seq
        self._answers.append(answer)
        self._say(answer)
        now = monotonic()
        if now >= self._status_due or tick.last:
            self._status_due = now + STATUS_INTERVAL
            status = agent.status(
                tick.seq, tick.stamp, missed=self._missed, rejected=self._rejects.count, pid=os.getpid()
            )
            self._session.publish(self._keys["status"], status)

    def _hear(self, agent: Agent, tick: Tick) -> None:
        """Give the agent the plans from before this tick; those of this tick and of the next flight wait."""
        ready = [plan for plan in self._plans if plan.episode == tick.episode and plan.seq < tick.seq]
        for plan in sorted(ready, key=lambda plan: plan.seq):
            agent.receive(plan)
        waiting = [
            plan
            for plan in self._plans
            if plan.episode == tick.episode + 1 or (plan.episode == tick.episode and plan.seq >= tick.seq)
        ]
        self._plans = deque(waiting, maxlen=KEPT_PLANS)

    def _say(self, answer: Answer) -> None:
        """The plan first: once the world has the command, the plan is known to be on its way."""
        if answer.plan is not None:
            self._session.publish(self._keys["plan"], answer.plan)
        self._session.publish(self._keys["command"], answer.command)

    def _learn(self) -> bool:
        """Ask the world what is flown. False if it does not say."""
        try:
            setup = self._session.setup()
            if setup is None:
                return False
            if self._setup is None or self._setup[0] != setup.episode:
                self._begin(Scenario.model_validate_json(setup.scenario), setup.episode)
                self._lockstep = setup.mode == "lockstep"
        except (WireError, ValidationError) as error:
            self._rejects.add("setup", error)
            return False
        if self._agent is not None:
            self._agent.set_faults(setup.faults)
        self._setup = (setup.episode, setup.revision)
        return True

    def _begin(self, scenario: Scenario, episode: int) -> None:
        """A new flight."""
        self._size = scenario.size
        here = self._robot <= scenario.size
        self._agent = Agent(scenario, self._robot, episode=episode) if here else None
        wanted = topics.plan(self._session.run, self._agent.upstream) if self._agent else None
        if wanted != self._listening_to:
            if self._listening_to is not None:
                self._session.unsubscribe(self._listening_to)
            if wanted is not None:
                self._session.subscribe(wanted)
            self._listening_to = wanted
        self._answers.clear()
        self._answered, self._missed = -1, 0


_WORDS = {"plan": topics.plan, "command": topics.command, "status": topics.status}
