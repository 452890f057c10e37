"""The world's part in the protocol of a run, without I/O and without a clock: arrivals and a time in, actions out.

In lockstep the world waits for the command of every live agent, and repeats its tick while one is missing, so that a
message lost on the way costs time, not truth. A robot that is lost while a tick is out has no part in this tick, and
joins again at the next at the earliest. In real time the world goes on with the newest commands.
"""

from collections.abc import Iterable
from dataclasses import replace

from formation.errors import WireError
from network import topics
from network.bus import Action, Connection, Incoming, Presence, Publish, Query, Reject, Sample
from network.messages import Command, Status, Tick
from network.stretch import Recording
from world.display import STATE_INTERVAL
from world.parts import Parts
from world.rate import RunningTime
from world.requests import Requests
from world.samples import message_of
from world.states import OUT, TABLE, Event, Phase

IDLE_SECONDS = 0.02
"""Between two looks while simulated time stands still [s]."""
RESEND_SECONDS = 0.1
"""A tick that is not answered for this long is sent again [s]."""
SHOWN_SECONDS = 1.0
"""A silent agent is shown as waited for after this long [s]."""
LAST_STATUS_SECONDS = 2.0
"""How long the last statuses of an episode are waited for [s]."""


class WorldNode:
    """Simulates a World with the agents that take part. Its table is world/states.py."""

    def __init__(self, run: str, parts: Parts) -> None:
        """A node that holds; world/process.py subscribes for it.

        Args:
            run: name of the run.
            parts: of the run, as it begins or goes on.
        """
        self.phase = Phase.HOLD
        self.parts = parts
        self._run = run
        self._world, self._rate, self._presence, self._control, self._journal, self._display = parts
        self._requests = Requests(self._world, self._control)
        self._commands: dict[int, Command] = {}
        self._tick: Tick | None = None
        """The newest that went out."""
        self._awaited: set[int] = set()
        """Robots that were live when the tick went out and were not lost since."""
        self._failed_at: dict[int, int] = {}
        """Of agents that did not answer: the first tick whose answer lets them in again."""
        self._sent_at = self._asked_at = 0.0
        """When the tick was sent last, and when the agents' patience began [s of running time]."""
        self._time = RunningTime()
        self._actions: list[Action] = []

    @property
    def _running(self) -> float:
        return self._time.now

    @property
    def over(self) -> bool:
        """Whether a user has asked the run to end."""
        return self._control.stop

    def patience(self, now: float) -> float:
        """Feed it again after this long [s], if nothing arrives before."""
        if self.phase in (Phase.ASK, Phase.CALL):
            return IDLE_SECONDS if self._requests else STATE_INTERVAL
        if self.phase in (Phase.DRIVE, Phase.PACE):
            return min(max(0.0, self._rate.left(now)), IDLE_SECONDS)
        return IDLE_SECONDS

    @property
    def enough(self) -> int:
        """It need not be woken for fewer messages of agents."""
        return max(1, len(self._awaited - self._commands.keys())) if self.phase is Phase.ASK else 1

    def feed(self, arrivals: Iterable[Incoming], now: float) -> list[Action]:
        """Take what has arrived, and go on as far as that allows.

        Args:
            arrivals: oldest first.
            now: monotonic time [s].

        Returns:
            What is to be done, in order.
        """
        stood_still = self._time.look(now)
        if stood_still:
            self._presence.stood_still(self._running, stood_still)
        for item in arrivals:
            self._take(item)
        self._presence.settle(self._running)
        self._note_changes()
        while True:
            if self._requests:
                self._obey()
            if not self._advance(now):
                break
        self._publish_state(now)
        if stretch := self._journal.take():
            self._actions.append(Publish(topics.stretch(self._run), stretch))
        return self._hand_over()

    def close(self, now: float) -> list[Action]:
        """What is to be done at the end: the last state."""
        self._display.hurry()
        self._publish_state(now)
        if stretch := self._journal.take(all_of_it=True):
            self._actions.append(Publish(topics.stretch(self._run), stretch))
        return self._hand_over()

    def _hand_over(self) -> list[Action]:
        actions, self._actions = self._actions, []
        if self._requests.actions:
            actions = [*self._requests.actions, *actions]
            self._requests.actions.clear()
        self._control.rejected += sum(isinstance(action, Reject) for action in actions)
        return actions

    # ------------------------------------------------------------------ time

    def _advance(self, now: float) -> bool:
        """One phase on, if its time has come. Whether there may be more to do at once."""
        world = self._world
        match self.phase:
            case Phase.HOLD:
                return self._begin_tick(now)
            case Phase.ASK | Phase.CALL:
                calling = self.phase is Phase.CALL
                if bool(self._commands) if calling else self._awaited <= self._commands.keys():
                    self._end_tick(dict(sorted(self._commands.items())), now)
                    self._rate.next(world.scenario.control_interval, now)
                    return True
                self._wait()
                return False
            case Phase.DRIVE | Phase.PACE:
                left = self._rate.left(now)
                if left > 0.0 and not (self._requests and left > STATE_INTERVAL):
                    return False
                if self.phase is Phase.DRIVE:
                    self._rate.note_overrun(world.scenario.control_interval, now)
                    self._end_tick(self._commands, now)
                else:
                    self.phase = TABLE[self.phase, Event.FINISHED if world.finished else Event.DUE]
                return True
            case Phase.LAST:
                return self._gather()

    def _begin_tick(self, now: float) -> bool:
        """Send the next tick, if there is somebody to answer it and the run goes on."""
        world, control = self._world, self._control
        lockstep = world.mode == "lockstep"
        if not (control.active or (lockstep and control.calling)):
            self._rate.hold(now)
            return False
        self._rate.begin(world.k, now)
        self._tick, self._awaited, self._commands = world.tick(), set(world.live), {}
        self._asked_at = self._running
        self._send_tick()
        if lockstep:
            self.phase = TABLE[self.phase, Event.ASKED if self._awaited else Event.CALLED]
        else:
            self._rate.next(world.scenario.control_interval, now)
            self.phase = TABLE[self.phase, Event.DRIVEN]
        return False

    def _end_tick(self, commands: dict[int, Command], now: float) -> None:
        world = self._world
        world.advance(commands)
        self._journal.note(commands)
        self._rate.end(now)
        self._control.note_tick()
        self.phase = TABLE[
            self.phase, Event.FINISHED if self.phase is Phase.DRIVE and world.finished else Event.COMPLETE
        ]
        self._sent_at = self._asked_at = self._running

    def _send_tick(self) -> None:
        assert self._tick is not None
        self._sent_at = self._running
        self._actions.append(Publish(topics.tick(self._run), self._tick))

    # ------------------------------------------------------------------ lockstep

    def _wait(self) -> None:
        """Repeat the tick; once the patience is over, count the silent agents as failed."""
        if self._running - self._sent_at > RESEND_SECONDS:
            self._send_tick()
        if not self._presence.certain:
            self._asked_at = self._running
        elif self._running - self._asked_at > self._world.scenario.lockstep.patience:
            for robot in sorted(self._awaited - self._commands.keys()):
                self._failed_at[robot] = self._world.k
                self._presence.silent(robot)
            self._note_changes()

    def _note_changes(self) -> None:
        """Robots lost while a tick is out have no part in it, and nobody waits for their plan of the tick before.

        Of those lost between two ticks nobody has that plan at the next.
        """
        tick, live, lost = self._tick, self._world.live, self._presence.take_lost()
        if self.phase is not Phase.ASK or tick is None:
            if lost:
                self._world.forget_plans(lost)
            return
        lost &= self._awaited
        if not lost and self._awaited == live:
            return
        self._awaited = live - {*tick.gone, *lost}
        if lost:
            for robot in lost:
                self._commands.pop(robot, None)
            self._tick = replace(tick, gone=sorted({*tick.gone, *lost}))
            self._send_tick()

    def _gather(self) -> bool:
        """The episode is over: wait for every live agent's last status."""
        world = self._world
        sent = {robot for robot, status in world.statuses.items() if status.seq >= world.k - 1}
        if world.live <= sent or self._running - self._asked_at > LAST_STATUS_SECONDS:
            self.phase = TABLE[self.phase, Event.GATHERED]
            return True
        if self._running - self._sent_at > RESEND_SECONDS and world.mode == "lockstep":
            self._send_tick()
        return False

    # ------------------------------------------------------------------ what comes in

    def _take(self, item: Incoming) -> None:
        match item:
            case Sample(key, payload):
                try:
                    self._take_sample(key, payload)
                except WireError as error:
                    self._actions.append(Reject(key, str(error)))
            case Query():
                self._requests.receive(item, self._running)
            case Presence("agent", robot, True, session):
                self._presence.appear(robot, session)
            case Presence("agent", robot, False):
                self._presence.disappear(robot, self._running)
            case Presence("launcher", _, here):
                self._presence.launcher = here
            case Presence("keeper", number, here):
                (self._presence.keepers.add if here else self._presence.keepers.discard)(number)
            case Presence("recorder", _, here):
                self._journal.wanted = here
                self._control.recording = self._control.recording if here else None
            case Connection(up):
                self._presence.connection(self._running, up=up)
            case _:
                pass

    def _take_sample(self, key: str, payload: bytes) -> None:
        world = self._world
        match message_of(world, key, payload):
            case Status() as status:
                world.hear(status)
            case Recording() as recording:
                self._control.recording = recording
            case Command() as command if world.mode == "realtime":
                self._commands[command.sender] = command
            case Command() as command:
                self._take_command(command)

    def _take_command(self, command: Command) -> None:
        """In lockstep: for the tick that is out, of a robot that was not lost meanwhile."""
        robot, tick = command.sender, self._tick
        if robot not in self._world.live and command.seq >= self._failed_at.get(robot, 0):
            self._presence.speaks(robot)
        if self.phase not in OUT or tick is None or command.seq != tick.seq or robot in tick.gone:
            return
        if robot in self._world.live:
            self._commands.setdefault(robot, command)

    # ------------------------------------------------------------------ what users ask and see

    def _obey(self) -> None:
        while self.phase is not Phase.LAST and self._requests.carry_out_one(
            self._running, tick_is_out=self.phase in OUT
        ):
            self._display.hurry()
            if self._tick is not None and self._tick.episode != self._world.episode and self.phase is not Phase.HOLD:
                self.phase = TABLE[self.phase, Event.ABANDONED]

    def _publish_state(self, now: float) -> None:
        if self.phase is Phase.LAST or not self._display.due(now):
            return
        late = self.phase is Phase.ASK and self._running - self._asked_at > SHOWN_SECONDS
        waited = self._awaited - self._commands.keys() if late else set()
        self._actions.append(Publish(topics.state(self._run), self._display.state(now, waited)))
