"""The world's process: ticks out, commands in, what people ask, and the pace of it all.

In lockstep the world waits for every live agent's command and says its tick again while one is missing, so that a
message lost with the router costs time, not truth. In real time it goes on with the newest commands.
"""

import logging
from collections import deque
from queue import Empty
from time import monotonic

from formation.errors import EchelonError, WireError
from formation.faults import preset
from formation.scenario import Scenario, load, parse
from network import control, keys
from network.codec import decode, encode
from network.control import Operation
from network.lifetime import Lifetime
from network.messages import Command, Reply, Request, RunStatus, Status
from network.rejects import Rejects
from network.session import Incoming, Presence, Query, Sample, Session
from world.world import World

STATE_INTERVAL = 0.05
"""Wall-clock time between two states for people [s]."""
RESEND_SECONDS = 0.1
"""A tick that is not answered so long is said again."""
GRACE_SECONDS = 1.0
"""An agent that does not answer for so long is no longer waited for."""
RETURN_SECONDS = 3.0
"""How long agents are waited for after the router came back."""
CATCH_UP_SECONDS = 0.2
"""A pace that fell behind by more is not made up for."""
MAX_AHEAD = 1.0
"""A message may be stamped so far ahead of the world's time [s]."""

_log = logging.getLogger("echelon")


class Driver:
    """Drives a World over a Session until its lifetime is over."""

    def __init__(self, session: Session, world: World, lifetime: Lifetime, *, speed: float, start: bool) -> None:
        """Declare what the world says and hears.

        Args:
            session: of this process.
            world: what is driven.
            lifetime: says when to end.
            speed: simulated seconds per second; 0 means as fast as possible.
            start: begin as soon as every agent is there.
        """
        self._session, self._world, self._lifetime = session, world, lifetime
        self._speed = speed
        self._status: RunStatus = "waiting"
        self._go = start
        self._budget: int | None = None  # ticks left of a Step
        self._asked: deque[tuple[Operation, Query]] = deque()
        self._commands: dict[int, Command] = {}
        self._present: set[int] = set()
        self._rejects = Rejects()
        self._states = self._overruns = 0
        self._due = self._state_due = monotonic()
        self._pace: deque[tuple[float, float]] = deque()
        self._stop = False
        self._began: float | None = None  # wall clock at the flight's first and after its last tick
        self._ended = 0.0
        self._lost_at: float | None = None
        run = session.run
        self._keys = {"tick": keys.tick(run), "state": keys.state(run)}
        session.announce(self._keys["tick"], reliable=world.mode == "lockstep")
        session.announce(self._keys["state"])
        session.subscribe(keys.command(run, "*"))
        session.subscribe(keys.status(run, "*"))
        session.serve(keys.control(run))
        session.watch()
        session.appear("world")

    def run(self) -> None:
        """Until told to end."""
        while not (self._lifetime.over or self._stop):
            self._answer_people()
            self._choose_status()
            self._say_state()
            if self._status != "running" and not self._budget:
                self._listen(0.02)
                self._due = monotonic()
            elif self._world.mode == "lockstep":
                self._note_begin()
                self._lockstep()
            else:
                self._note_begin()
                self._realtime()
        self._say_state(now=True)

    # ------------------------------------------------------------------ time

    def _lockstep(self) -> None:
        world = self._world
        tick = world.tick()
        self._commands.clear()
        self._session.publish(self._keys["tick"], tick)
        began = said = monotonic()
        while world.live - self._commands.keys() and not self._lifetime.over:
            self._listen(RESEND_SECONDS)
            self._say_state()
            now = monotonic()
            if now - said > RESEND_SECONDS:
                self._session.publish(self._keys["tick"], tick)
                said = now
                if not self._reachable():
                    began = now
                elif now - began > GRACE_SECONDS:
                    for robot in world.live - self._commands.keys():
                        self._lose(robot, "does not answer")
        if self._lifetime.over:
            return
        world.advance({robot: self._commands[robot] for robot in sorted(self._commands)})
        self._after_tick()
        self._wait_until_due()

    def _realtime(self) -> None:
        world = self._world
        self._session.publish(self._keys["tick"], world.tick())
        self._wait_until_due()
        late = monotonic() - self._due
        if self._speed and late > world.scenario.control_interval / self._speed:
            self._overruns += 1
        self._reachable()
        world.advance(self._commands)
        self._commands = {}
        self._after_tick()

    def _after_tick(self) -> None:
        self._ended = monotonic()
        if self._budget:
            self._budget -= 1
        if self._world.finished:
            self._gather_last_words()

    def _note_begin(self) -> None:
        if self._world.k == 0:
            self._began = monotonic()

    def _wait_until_due(self) -> None:
        """Keep the pace, listening meanwhile."""
        if not self._speed:
            self._listen(0.0)
            return
        self._due += self._world.scenario.control_interval / self._speed
        now = monotonic()
        if now - self._due > CATCH_UP_SECONDS:
            self._due = now
        while not self._lifetime.over:
            self._listen(self._due - monotonic())
            self._say_state()
            if monotonic() >= self._due:
                return

    def _gather_last_words(self) -> None:
        """The flight is over: every live agent says its last status."""
        last, until = self._world.k - 1, monotonic() + GRACE_SECONDS
        while not self._lifetime.over and monotonic() < until:
            said = {robot for robot, status in self._world.statuses.items() if status.seq >= last}
            if self._world.live <= said:
                break
            self._listen(0.01)

    # ------------------------------------------------------------------ what comes in

    def _listen(self, seconds: float) -> None:
        """Take what has come in; if nothing has, wait for one thing at most so long."""
        inbox = self._session.inbox
        try:
            self._take(inbox.get(timeout=max(0.0, seconds)) if seconds > 0 else inbox.get_nowait())
            while True:
                self._take(inbox.get_nowait())
        except Empty:
            pass

    def _take(self, item: Incoming) -> None:
        match item:
            case Sample(key, payload):
                try:
                    self._take_sample(key, payload)
                except WireError as error:
                    self._rejects.add(key, error)
            case Query():
                self._take_query(item)
            case Presence("agent", robot, here):
                if here:
                    self._present.add(robot)
                    self._gain(robot)
                else:
                    self._present.discard(robot)
                    if self._reachable():
                        self._lose(robot, "lost")
            case _:
                pass

    def _take_sample(self, key: str, payload: bytes) -> None:
        world = self._world
        message: Command | Status = decode(Command if key.endswith("/command") else Status, payload)
        if message.sender != keys.robot_of(key):
            raise WireError(f"expected the sender named in the key; got {message.sender}")
        if message.sender not in world.robots or message.epoch != world.epoch:
            return  # an agent that has not yet heard of the flight or scenario of now
        if message.stamp > world.now + MAX_AHEAD:
            raise WireError(f"expected a stamp up to {world.now:g} s; got {message.stamp:g} s")
        if isinstance(message, Status):
            world.hear(message)
            return
        self._gain(message.sender)
        if world.mode == "realtime" or message.seq == world.k:
            self._commands[message.sender] = message

    def _take_query(self, query: Query) -> None:
        try:
            operation = control.operation(decode(Request, query.payload))
        except EchelonError as error:
            if isinstance(error, WireError):
                self._rejects.add("control", error)
            query.answer(encode(Reply(False, str(error))))
            return
        if isinstance(operation, control.GetSetup):  # agents need it to answer this very tick
            query.answer(encode(self._world.setup()))
        else:
            self._asked.append((operation, query))

    def _gain(self, robot: int) -> None:
        world = self._world
        if robot in world.robots and robot not in world.live and robot in self._present:
            world.live.add(robot)
            world.event("agent", f"agent {robot} is here")

    def _lose(self, robot: int, why: str) -> None:
        if robot in self._world.live:
            self._world.live.discard(robot)
            self._world.event("agent", f"agent {robot} {why}")

    def _reachable(self) -> bool:
        """Whether the router is there and agents had time to come back after it was not."""
        if not self._session.connected:
            if self._lost_at is None:
                self._world.event("run", "router lost: holding")
            self._lost_at = monotonic()
            return False
        if self._lost_at is None:
            return True
        if self._world.live <= self._present or monotonic() - self._lost_at > RETURN_SECONDS:
            self._lost_at = None
            self._world.event("run", "router is back")
            for robot in self._world.live - self._present:
                self._lose(robot, "lost")
            return True
        return False

    # ------------------------------------------------------------------ people

    def _choose_status(self) -> None:
        world = self._world
        if world.finished:
            self._status, self._budget = "finished", None
        elif not world.live or (world.k == 0 and set(world.robots) - world.live):
            self._status = "waiting"
        else:
            self._status = "running" if self._go else "paused"

    def _answer_people(self) -> None:
        """Do what was asked since the last tick."""
        while self._asked:
            operation, query = self._asked.popleft()
            try:
                value = self._do(operation)
            except EchelonError as error:
                query.answer(encode(Reply(False, str(error))))
            else:
                query.answer(encode(Reply(True, value=value)))
            self._state_due = monotonic()  # people see what they did at once

    def _do(self, operation: Operation) -> dict[str, object]:
        world = self._world
        match operation:
            case control.Start():
                if world.finished:
                    world.reset()
                self._go, self._budget = True, None
            case control.Pause():
                self._go, self._budget = False, None
            case control.Step(ticks=ticks):
                self._go, self._budget = False, ticks
            case control.Reset():
                world.reset()
            case control.Speed(speed=speed):
                self._speed = speed
            case control.SetFault(link=link, changes=changes, seconds=seconds):
                world.change_fault(link, changes, seconds and world.now + seconds)
            case control.SetPreset(link=link, preset=name, seconds=seconds):
                world.change_fault(link, preset(name).model_dump(), seconds and world.now + seconds)
            case control.Clear(link=link):
                world.clear_faults(link)
            case control.UseScenario(scenario=name, settings=settings):
                self._use(load(name, settings))
            case control.UseController(controller=name):
                self._use(with_controller(world.scenario, name))
            case control.Stop():
                self._stop = True
            case control.GetSummary(warmup=warmup):
                wall = self._ended - self._began if self._began is not None else 0.0
                return {**world.summary(warmup=warmup), "wall_s": wall, "overruns": self._overruns}
        return {}

    def _use(self, scenario: Scenario) -> None:
        self._world.use(scenario)
        self._world.live = self._present & set(self._world.robots)
        self._budget = None

    def _say_state(self, *, now: bool = False) -> None:
        at = monotonic()
        if at < self._state_due and not now:
            return
        self._state_due = at + STATE_INTERVAL
        world = self._world
        self._pace.append((at, world.now))
        while self._pace[0][0] < at - 1.0 and len(self._pace) > 2:
            self._pace.popleft()
        (t0, s0), (t1, s1) = self._pace[0], self._pace[-1]
        self._states += 1
        state = world.state(
            seq=self._states,
            status=self._status,
            speed=self._speed,
            pace=max(0.0, (s1 - s0) / (t1 - t0)) if t1 > t0 else 0.0,
            overruns=self._overruns,
            rejected=self._rejects.count,
            waiting_for=sorted(set(world.robots) - world.live),
        )
        self._session.publish(self._keys["state"], state)


def with_controller(scenario: Scenario, name: str) -> Scenario:
    """The scenario with another controller; weights and switches of the one before do not fit and are left out.

    Raises:
        ScenarioError: there is no such controller; the text lists them.
    """
    raw = scenario.model_dump(exclude_unset=True)
    kept = {key: raw.get("controller", {})[key] for key in _SHARED if key in raw.get("controller", {})}
    return parse({**raw, "controller": {**kept, "name": name}}, where="controller")


_SHARED = ("horizon", "prediction_interval", "plan_every", "age_plans")
