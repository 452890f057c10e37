"""An agent's part in the protocol of a run, without I/O and without a clock: arrivals and a time in, actions out.

In lockstep it answers a tick only when it has the plan that its upstream neighbour sent at the tick before, uses no
other, and answers each tick once; an answer that may be lost is sent again unchanged. The trajectory then depends on
which robots took part in which tick, and on nothing else that the network does.
"""

from collections.abc import Iterable
from functools import lru_cache

from pydantic import ValidationError

from agents.agent import Agent
from agents.controllers.own import check_loaded
from agents.plausibility import MAX_AHEAD, check, is_believable
from agents.sending import Answer
from agents.states import TABLE, Event, Output, State
from formation.errors import ScenarioError, WireError
from formation.pattern import place
from formation.scenario.registry import register_unloaded
from formation.scenario.reshaping import with_changes
from formation.scenario.scenario import Scenario
from network import bus, topics
from network.bus import Action, Appear, Ask, Incoming, Publish, Read, Reject, Response, Sample, Subscribe, Unsubscribe
from network.codec import decode
from network.control import GetSetup, request
from network.messages import WORLD, Plan, Status, Tick
from network.requests import Setup

STATUS_INTERVAL = 0.1
"""Wall-clock time between two statuses [s]."""
ASK_SECONDS = 0.2
"""A request for the Setup that is not answered for this long is sent again [s]."""
MAX_TICKS_AHEAD = 10
"""A plan may be so many ticks ahead of the newest tick, or MAX_AHEAD."""
KEPT_PLANS = 256
"""Plans that wait for their tick, at most; the oldest go first."""
KEPT_ANSWERS = 2
"""Answers that can be sent again: agents of a lockstep run are at most one tick apart."""
RECENT_EPISODES = 1000
"""An episode number that is lower by at most so much is an earlier episode of the same world."""


class AgentNode:
    """Keeps one robot's agent in touch with the world and its upstream neighbour. Its table is agents/states.py."""

    def __init__(self, run: str, robot: int, *, pid: int = 0, phase: float = 0.0) -> None:
        """A node before its first Setup.

        Args:
            run: name of the run.
            robot: its number, from 1.
            pid: of its process, for its statuses.
            phase: of its statuses among those of others in the process, as a share of their interval.
        """
        self.state = State.NEW
        self.rejected = 0
        """Payloads that were not valid messages."""
        self._run, self._robot, self._pid = run, robot, pid
        self._plan_key, self._command_key = topics.plan(run, robot), topics.command(run, robot)
        self._status_key = topics.status(run, robot)
        self._setup: Setup | None = None
        self._scenario: Scenario | None = None
        self._agent: Agent | None = None
        self._plan_keys: set[str] = set()
        self._deaf_until = -1  # since the ring changed, it hears its neighbours from this tick on
        self._plans: dict[tuple[int, int, int], Plan] = {}
        """Of the neighbours that the agent hears, by episode, seq and sender."""
        self._tick: Tick | None = None
        """The newest that fits the episode and is not answered."""
        self._unknown: Tick | None = None
        """The newest of another episode, or too far ahead to be believed."""
        self._newest = (-1, -1, -1.0)  # episode, seq and stamp of the newest tick that was believed
        self._repeated = False
        self._answers: list[Answer] = []
        self._status_of: Tick | None = None  # answered, and a status of it is due
        self._last_status: Status | None = None  # of the episode's last tick; like an answer, it may be lost
        self._answered, self._missed = -1, 0
        self._ask_at, self._status_at, self._phase = 0.0, 0.0, phase
        self._actions: list[Action] = []

    @property
    def patience(self) -> float:
        """Feed it again after this long [s], if nothing arrives before."""
        pause = ASK_SECONDS if self.state in (State.NEW, State.ASKING) else 0.5
        return pause if self._status_of is None else 0.0

    @property
    def enough(self) -> int:
        """It need not be woken for fewer plans: unless it waits for one, it looks at them when there is a tick."""
        return 1 if self.state is State.BLOCKED else KEPT_PLANS

    def feed(self, arrivals: Iterable[Incoming], now: float) -> list[Action]:
        """Take what has arrived, oldest first, at monotonic time `now` [s]. What is to be done, in order."""
        if self._status_of is not None:
            self._publish_status(self._status_of)
        for item in arrivals:
            try:
                match item:
                    case Read(_, Tick() as tick):
                        self._receive_tick(tick)
                    case Read(key, Plan() as plan):
                        self._receive_plan(key, plan)
                    case Read(_, Setup() as setup):
                        self._receive_setup(setup)
                    case Sample(key, payload) if key.endswith("/tick"):
                        self._receive_tick(decode(Tick, payload))
                    case Sample(key, payload):
                        self._receive_plan(key, decode(Plan, payload))
                    case Response(_, payload):
                        self._receive_setup(decode(Setup, payload))
            except (WireError, ScenarioError, ValidationError) as error:
                self._reject(item.key if isinstance(item, Sample | Read) else "setup", error)
        if self._repeated:
            self._repeated = False
            for answer in self._answers:
                self._publish(answer)
            if self._last_status is not None:
                self._actions.append(Publish(self._status_key, self._last_status))
        self.state, output = TABLE[self.state, self._event()]
        while output is Output.ANSWER:
            self._answer(now)
            self.state, output = TABLE[self.state, self._event()]
        if output is Output.ASK and now >= self._ask_at:
            self._ask_at = now + ASK_SECONDS
            self._actions.append(Ask(request(GetSetup())))
        actions, self._actions = self._actions, []
        return actions

    def _event(self) -> Event:
        tick, agent, setup = self._tick, self._agent, self._setup
        if tick is None or agent is None or setup is None:
            return Event.NOTHING if self._unknown is None else Event.UNKNOWN
        if setup.revision != tick.revision:
            return Event.UNKNOWN
        hears = setup.mode == "lockstep" and tick.seq > self._deaf_until
        awaited = set(agent.hears) & set(tick.planned) - set(tick.gone) if hears else set()
        if any((tick.episode, tick.seq - 1, sender) not in self._plans for sender in awaited):
            return Event.LACKING if self._unknown is None else Event.UNKNOWN  # the plan may never come
        return Event.READY

    # ------------------------------------------------------------------ what comes in

    def _receive_tick(self, tick: Tick) -> None:
        if tick.sender != WORLD:
            raise WireError(f"expected the world's tick; got one of {tick.sender}")
        setup = self._setup
        if setup is not None and 0 < setup.episode - tick.episode <= RECENT_EPISODES:
            return  # of an episode that is over
        scenario = self._scenario
        if setup is None or scenario is None or tick.episode != setup.episode:
            self._unknown = tick
            return
        if not is_believable(tick, setup, scenario, answered=self._answered, newest=self._newest[2]):
            self._unknown = tick
            return
        check(tick, scenario)
        self._repeated |= setup.mode == "lockstep" and tick.seq == self._newest[1]
        if tick.seq < self._newest[1] or tick.revision < setup.revision:
            if tick.seq > self._answered and tick.seq >= self._newest[1]:
                self._unknown = tick  # the Setup is ahead of the world, or never was the world's
            return
        self._newest = tick.episode, tick.seq, tick.stamp
        if tick.seq > self._answered and self._agent is not None:
            self._tick = None if self._robot in tick.gone else tick

    def _receive_plan(self, key: str, plan: Plan) -> None:
        if plan.sender != topics.robot_of(key):
            raise WireError(f"expected the sender named in the key; got {plan.sender}")
        setup = self._setup
        if setup is None or 0 < setup.episode - plan.episode <= RECENT_EPISODES:
            return
        if plan.episode == setup.episode:
            _, seq, stamp = self._newest
            if 0 <= seq < plan.seq - MAX_TICKS_AHEAD and plan.stamp > stamp + MAX_AHEAD:
                raise WireError(f"expected a stamp up to {stamp:g} s; got {plan.stamp:g} s")
            if setup.mode == "lockstep" and plan.seq < self._answered:
                return  # of a tick that is over
        self._plans.setdefault((plan.episode, plan.seq, plan.sender), plan)
        if len(self._plans) > KEPT_PLANS:
            del self._plans[next(iter(self._plans))]

    def _receive_setup(self, setup: Setup) -> None:
        """Take the world's answer, unless it is older than what is known."""
        held, unknown = self._setup, self._unknown
        if held is None:
            self._begin(setup)
            self.state = State.IDLE
            own = [(topic.key(self._run, self._robot), topic.is_reliable(setup.mode)) for topic in topics.OF_AGENTS]
            self._actions += [*(bus.Announce(*topic) for topic in own), Appear("agent", self._robot)]
        elif setup.episode == held.episode:
            asked_for = unknown is not None and unknown.revision == setup.revision < held.revision
            if (setup.revision, setup.stamp) < (held.revision, held.stamp) and not asked_for:
                return
            self._renew(setup)
        elif unknown is None or unknown.episode != setup.episode:
            return  # of no episode that the world is known to be in
        else:
            self._begin(setup)
        self._ask_at = 0.0
        self._unknown = None
        if unknown is not None:  # if it is unknown still, it was never the world's, or the world will repeat it
            self._receive_tick(unknown)
            self._unknown = None

    # ------------------------------------------------------------------ episodes

    def _begin(self, setup: Setup) -> None:
        """A new episode. Raises ScenarioError if its controller is a user's own and not the one that is loaded here."""
        register_unloaded(setup.user_code)
        scenario = _scenario(setup.scenario)
        check_loaded(setup.user_code, scenario.controller.name)
        agent = self._made(scenario, setup) if self._robot <= scenario.size else None
        self._scenario, self._agent, self._setup = scenario, agent, setup
        self._answers, self._answered, self._missed, self._last_status = [], -1, 0, None
        self._tick, self._newest, self._repeated, self._deaf_until = None, (setup.episode, -1, -1.0), False, -1
        self._plans = {key: plan for key, plan in self._plans.items() if key[0] == setup.episode}
        self._listen(agent)
        self._renew(setup)

    def _made(self, scenario: Scenario, setup: Setup) -> Agent:
        """An agent that begins with the shape and the ring of now, as one process makes it."""
        return Agent(with_changes(scenario, setup.changes), self._robot, episode=setup.episode, away=setup.away)

    def _listen(self, agent: Agent | None) -> None:
        """Subscribe to the plans of those whom the agent hears, and to no others."""
        wanted = {topics.plan(self._run, sender) for sender in agent.hears} if agent else set()
        self._actions += [Unsubscribe(key) for key in sorted(self._plan_keys - wanted)]
        self._actions += [Subscribe(key) for key in sorted(wanted - self._plan_keys)]
        self._plan_keys = wanted

    def _renew(self, setup: Setup) -> None:
        """Another revision of the episode, or the same as of now."""
        agent, scenario, held = self._agent, self._scenario, self._setup
        if agent is not None and scenario is not None and held is not None:
            n, i = scenario.size, self._robot
            if place(i, n, setup.away) != place(i, n, held.away):
                agent = self._agent = self._made(scenario, setup)
                self._deaf_until = setup.closed_at
                self._listen(agent)
            elif setup.changes != held.changes:
                agent.reshape(with_changes(scenario, setup.changes), round(setup.stamp / scenario.control_interval))
            agent.set_faults(setup.faults)
        self._setup = setup
        if self._tick is not None and self._tick.revision < setup.revision:
            self._tick = None  # the world is past it

    # ------------------------------------------------------------------ what goes out

    def _answer(self, now: float) -> None:
        tick, agent, setup = self._tick, self._agent, self._setup
        assert tick is not None
        assert agent is not None
        assert setup is not None
        self._tick = None
        lockstep = setup.mode == "lockstep"
        if not lockstep and self._answered >= 0:
            self._missed += tick.seq - self._answered - 1
        for key in sorted(key for key in self._plans if key[0] == tick.episode and key[1] < tick.seq):
            plan = self._plans.pop(key)
            fits = not lockstep or (plan.seq == tick.seq - 1 and plan.sender in tick.planned)
            if fits and plan.seq >= self._deaf_until:
                agent.receive(plan)
        answer = agent.step(tick)
        self._answered = tick.seq
        self._answers = [*self._answers[1 - KEPT_ANSWERS :], answer]
        self._publish(answer)
        if now >= self._status_at or tick.last:
            self._status_at, self._phase = now + (1.0 - self._phase) * STATUS_INTERVAL, 0.0
            self._status_of = tick

    def _publish_status(self, tick: Tick) -> None:
        """After the answer has gone out: nobody waits for a status, and it takes longer than an answer."""
        self._status_of = None
        if self._agent is not None:
            status = self._agent.status(
                tick.seq, tick.stamp, missed=self._missed, rejected=self.rejected, pid=self._pid
            )
            self._actions.append(Publish(self._status_key, status))
            self._last_status = status if tick.last else None

    def _publish(self, answer: Answer) -> None:
        """The plan first: once the world has the command, the plan is known to be on its way."""
        if answer.plan is not None:
            self._actions.append(Publish(self._plan_key, answer.plan))
        self._actions.append(Publish(self._command_key, answer.command))

    def _reject(self, key: str, error: Exception) -> None:
        self.rejected += 1
        self._actions.append(Reject(key, str(error)))


@lru_cache(maxsize=1)
def _scenario(text: str) -> Scenario:
    """The scenario, one for all agents of this process."""
    return Scenario.model_validate_json(text)
