"""The world's process: ticks out, commands in, what people ask, and the pace of it all.

In lockstep the world waits for every live agent's command and says its tick again while one is missing, so that a
message lost with the router costs time, not truth. In real time it goes on with the newest commands.
"""

from collections import deque
from queue import Empty
from time import monotonic

from formation.errors import EchelonError, WireError
from network import control, topics
from network.bus import Incoming, Presence, Query, Sample
from network.codec import decode, encode
from network.control import Operation
from network.lifetime import Lifetime
from network.messages import Command, Reply, Request, Status
from network.throttled_log import ThrottledLog
from network.zenoh_bus import ZenohBus
from world.presence import AgentPresence
from world.rate import Rate
from world.run_control import RunControl
from world.world import World

STATE_INTERVAL = 0.05
"""Wall-clock time between two states for people [s]."""
IDLE_SECONDS = 0.02
"""Between two looks around while time stands still."""
RESEND_SECONDS = 0.1
"""A tick that is not answered so long is said again."""
GRACE_SECONDS = 5.0
"""An agent that is there but does not answer for so long is no longer waited for. A dead or stopped one is noticed by
its liveliness token, within a second; a merely slow one on a loaded machine must not change a lockstep run."""
LAST_WORDS_SECONDS = 2.0
"""How long the last statuses of a flight are waited for."""
MAX_AHEAD = 1.0
"""A message may be stamped so far ahead of the world's time [s]."""


class WorldNode:
    """Drives a World over a ZenohBus until its lifetime is over."""

    def __init__(self, session: ZenohBus, world: World, lifetime: Lifetime, *, speed: float, start: bool) -> None:
        """Declare what the world says and hears.

        Args:
            session: of this process.
            world: what is driven.
            lifetime: says when to end.
            speed: simulated seconds per second; 0 means as fast as possible.
            start: begin as soon as every agent is there.
        """
        self._session, self._world, self._lifetime = session, world, lifetime
        self._pace = Rate(speed)
        self._roster = AgentPresence(session, world)
        self._orders = RunControl(world, self._pace, self._roster, go=start)
        self._asked: deque[tuple[Operation, Query]] = deque()
        self._commands: dict[int, Command] = {}
        self._rejects = ThrottledLog()
        self._states, self._state_due = 0, monotonic()
        run = session.run
        self._keys = {"tick": topics.tick(run), "state": topics.state(run)}
        session.announce(self._keys["tick"], reliable=world.mode == "lockstep")
        session.announce(self._keys["state"])
        session.subscribe(topics.command(run, "*"))
        session.subscribe(topics.status(run, "*"))
        session.serve(topics.control(run))
        session.watch()
        session.appear("world")

    @property
    def _over(self) -> bool:
        return self._lifetime.over or self._orders.stop

    def run(self) -> None:
        """Until told to end."""
        while not self._over:
            self._answer_people()
            self._say_state()
            if not self._orders.active:
                self._listen(IDLE_SECONDS)
                self._pace.hold()
                continue
            self._pace.begin(self._world.k)
            passed = self._lockstep() if self._world.mode == "lockstep" else self._realtime()
            if not passed:
                break
            self._pace.end()
            self._orders.note_tick()
            if self._world.finished:
                self._gather_last_words()
        self._state_due = 0.0
        self._say_state()

    # ------------------------------------------------------------------ time

    def _lockstep(self) -> bool:
        """One tick with every live agent's command. False if the process shall end meanwhile."""
        world = self._world
        tick = world.tick()
        self._commands.clear()
        self._session.publish(self._keys["tick"], tick)
        began = said = monotonic()
        while world.live - self._commands.keys():
            if self._lifetime.over:
                return False
            self._listen(RESEND_SECONDS)
            self._say_state()
            now = monotonic()
            if now - said > RESEND_SECONDS:
                self._session.publish(self._keys["tick"], tick)
                said = now
                if not self._roster.reachable():
                    began = now
                elif now - began > GRACE_SECONDS:
                    for robot in sorted(world.live - self._commands.keys()):
                        self._roster.lose(robot, "does not answer")
        world.advance({robot: self._commands[robot] for robot in sorted(self._commands)})
        self._wait_until_due()
        return True

    def _realtime(self) -> bool:
        """One tick with whatever commands have come in. False if the process shall end meanwhile."""
        world = self._world
        self._session.publish(self._keys["tick"], world.tick())
        self._wait_until_due()
        self._pace.note_overrun(world.scenario.control_interval)
        self._roster.reachable()
        commands, self._commands = self._commands, {}
        world.advance({robot: command for robot, command in commands.items() if command.episode == world.episode})
        return not self._lifetime.over

    def _wait_until_due(self) -> None:
        """Keep the pace, listening meanwhile; where ticks are far apart, an order cuts the wait short."""
        self._pace.next(self._world.scenario.control_interval)
        self._listen(min(self._pace.left, IDLE_SECONDS))
        while self._pace.left > 0 and not (self._over or (self._asked and self._pace.left > STATE_INTERVAL)):
            self._say_state()
            self._listen(min(self._pace.left, IDLE_SECONDS))

    def _gather_last_words(self) -> None:
        """The flight is over: every live agent says its last status."""
        last, until = self._world.k - 1, monotonic() + LAST_WORDS_SECONDS
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
            self._take(inbox.get(timeout=seconds) if seconds > 0 else inbox.get_nowait())
            while True:
                self._take(inbox.get_nowait())
        except Empty:
            self._roster.settle()

    def _take(self, item: Incoming) -> None:
        match item:
            case Sample(key, payload):
                try:
                    self._take_sample(key, payload)
                except WireError as error:
                    self._reject(key, error)
            case Query():
                self._take_query(item)
            case Presence("agent", robot, here):
                (self._roster.appear if here else self._roster.disappear)(robot)
            case Presence("launcher", _, here):
                self._roster.launcher = here
            case _:
                pass

    def _take_sample(self, key: str, payload: bytes) -> None:
        world = self._world
        message = decode(Command, payload) if key.endswith("/command") else decode(Status, payload)
        if message.sender != topics.robot_of(key):
            raise WireError(f"expected the sender named in the key; got {message.sender}")
        if message.episode != world.episode:
            return  # an agent that has not yet heard of the flight of now
        if message.sender not in world.robots:
            raise WireError(f"expected a robot of the scenario, 1 to {world.scenario.size}; got {message.sender}")
        if message.stamp > world.now + MAX_AHEAD:
            raise WireError(f"expected a stamp up to {world.now:g} s; got {message.stamp:g} s")
        if isinstance(message, Status):
            world.hear(message)
            return
        self._roster.gain(message.sender)
        if world.mode == "realtime" or message.seq == world.k:
            self._commands[message.sender] = message

    def _take_query(self, query: Query) -> None:
        try:
            operation = control.operation(decode(Request, query.payload))
        except EchelonError as error:
            if isinstance(error, WireError):
                self._reject("control", error)
            query.answer(encode(Reply(False, str(error))))
            return
        if isinstance(operation, control.GetSetup):  # agents need it to answer this very tick
            query.answer(encode(self._world.setup()))
        else:
            self._asked.append((operation, query))

    def _reject(self, key: str, error: WireError) -> None:
        self._rejects.add(key, error)
        self._orders.rejected = self._rejects.count

    # ------------------------------------------------------------------ people

    def _answer_people(self) -> None:
        """Do what was asked since the last tick; what changes holds from the next tick on, for everyone."""
        while self._asked:
            operation, query = self._asked.popleft()
            try:
                value = self._orders.obey(operation)
            except EchelonError as error:
                query.answer(encode(Reply(False, str(error))))
            except (ArithmeticError, MemoryError, ValueError) as error:  # no order may end the world
                query.answer(encode(Reply(False, f"cannot be done: {type(error).__name__} {error}")))
            else:
                query.answer(encode(Reply(True, value=value)))
            self._state_due = 0.0  # people see at once what they did

    def _say_state(self) -> None:
        now = monotonic()
        if now < self._state_due:
            return
        self._state_due = now + STATE_INTERVAL
        self._states += 1
        state = self._world.state(
            seq=self._states,
            status=self._orders.status,
            speed=self._pace.speed,
            pace=self._pace.measured(self._world.now),
            overruns=self._pace.overruns,
            rejected=self._rejects.count,
            waiting_for=self._roster.missing,
            dismissed=self._roster.dismissed,
            compare=self._orders.compare,
        )
        self._session.publish(self._keys["state"], state)
