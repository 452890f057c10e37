"""The world without any I/O: a tick out, commands in, one step; and the operations of its users.

It reads no clock. Its caller (runtime/inprocess.py, world/process.py) decides when the next tick is due.
"""

from collections import deque
from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from formation.arrays import FloatArray
from formation.faults import PERFECT, Fault
from formation.link_ids import LinkId
from formation.metrics import pattern_errors, tracking_error
from formation.scenario.scenario import Scenario
from formation.scenario.user_code import SHOWN
from network.messages import WORLD, Command, State, Status, Tick
from network.requests import Setup
from network.values import NO_DRIVE, NO_PLACES, NO_POSES, Driving, Event, LinkCounts, Mode, RunStatus
from world.bodies.interface import Bodies
from world.bodies.own import user_code, user_code_of
from world.bodies.registry import bodies_for
from world.command_links import CommandLinks
from world.contacts import Contacts, Excursions
from world.convergence import Convergence
from world.driver import Driver
from world.faults import FaultState
from world.sight import Sight
from world.states import SKIPPED
from world.trace import Trace

SHOWN_EVENTS, KEPT_EVENTS = 40, 5000


class World:
    """Bodies, links to them, faults, events and trace of one run; `reset` starts a new episode."""

    def __init__(self, scenario: Scenario, *, episode: int = 0, endless: bool = False, mode: Mode = "lockstep") -> None:
        """A world at the start of an episode.

        Args:
            scenario: of the run.
            episode: its number, put into every message.
            endless: continue past the duration, if the path is closed; then no trace is kept.
            mode: "lockstep" or "realtime", for displays.
        """
        self.scenario, self.episode, self.mode = scenario, episode, mode
        self._endless_wish, self.revision = endless, 0
        self.events: deque[Event] = deque(maxlen=KEPT_EVENTS)
        self._event_count = 0
        self._begin()
        self.event("run", f"scenario {scenario.name}, controller {scenario.controller.name}, seed {scenario.seed}")

    def bodies_for(self, scenario: Scenario) -> Bodies:
        """The bodies of an episode."""
        return bodies_for(scenario)

    def _begin(self) -> None:
        """Begin an episode of the scenario."""
        scenario = self.scenario
        self.k, self._earlier_events = 0, self._event_count
        self.resumed: list[int] = []  # ticks of the episode at which a world went on from a saved state
        self.endless = self._endless_wish and scenario.path.endless
        self.plant, self._sight = self.bodies_for(scenario), Sight(scenario)
        self.faults = FaultState(scenario)
        self.faults.update(0.0)
        self.driver = Driver(scenario, forgets=self.endless) if scenario.driven else None
        self.reference = self.driver.reference if self.driver else scenario.reference()
        self.trace = None if self.endless else Trace(scenario, scenario.ticks, self.reference)
        if self.trace:
            self.trace.start(self.plant.poses)
        self.inputs: FloatArray = np.zeros((scenario.size, 2))  # commanded over the tick before
        self.counts: dict[LinkId, LinkCounts] = {}
        self.statuses: dict[int, Status] = {}
        self.live: set[int] = set()
        self.contacts, self.excursions = Contacts(scenario.bodies.radii(scenario.size)), Excursions(scenario)
        self.convergence, self._commands = Convergence(), CommandLinks(scenario)
        self._planned: list[int] = []
        self._tick: Tick | None = None
        self._commands.set_faults(self.faults.table)
        self._look()
        self._drive()

    @property
    def robots(self) -> range:
        """Numbers of the robots."""
        return range(1, self.scenario.size + 1)

    @property
    def now(self) -> float:
        """Simulated time [s]."""
        return self.k * self.scenario.control_interval

    @property
    def finished(self) -> bool:
        """Whether the episode has reached its duration."""
        return not self.endless and self.k >= self.scenario.ticks

    def tick(self) -> Tick:
        """The Tick of now; the same message until `advance`."""
        if self._tick is None:
            measured = self.plant.measure()
            self._tick = Tick(
                sender=WORLD,
                seq=self.k,
                stamp=self.now,
                episode=self.episode,
                revision=self.revision,
                odometry=self.plant.odometry,
                planned=self._planned,
                measured=measured.tick if measured else None,
                poses=measured.poses if measured else NO_POSES,
                localised=measured.localised if measured else [],
                relatives=measured.relatives if measured else NO_PLACES,
                last=not self.endless and self.k == self.scenario.ticks - 1,
                seen=self._sight.see(self.k, self.plant.poses),
                drive=self.driver.message(self.k) if self.driver else NO_DRIVE,
            )
        return self._tick

    def advance(self, commands: Mapping[int, Command]) -> None:
        """Step by one tick, with the commands that were received for this one."""
        now = self.now
        self.inputs = inputs = np.array([self._commands.take(robot, commands.get(robot), now) for robot in self.robots])
        for text, severity in self._commands.reports():
            self.event("watchdog", text, severity)
        self.plant.move(inputs)
        if self.trace:
            self.trace.add(self.plant.poses, inputs, commands)
        for text, severity in self.convergence.reports(commands, now):
            self.event("agent", text, severity)
        for text in self.excursions.reports(commands, now):
            self.event("avoidance", text)
        self._planned = sorted([robot for robot, command in commands.items() if command.planned])
        self.excursions.add(inputs, self.plant.poses)
        self.k += 1
        self._look()
        self._tick = None
        self._drive()
        self._apply_faults()

    def _drive(self) -> None:
        """The driver's orders for the tick that is computed next."""
        for line in self.driver.begin(self.k) if self.driver else ():
            self.event("drive", line)

    def _look(self) -> None:
        """Count who touches whom."""
        for one, other in self.contacts.look(self.plant.poses):
            self.event("contact", f"robots {one} and {other} touch", "warning")

    def _apply_faults(self) -> None:
        changed = self.faults.update(self.now)
        for link, fault in changed:
            self.event("fault", f"{link}: {fault.words()}", "info" if fault == PERFECT else "warning")
        if changed:
            self.revision += 1
            self._commands.set_faults(self.faults.table)

    def reset(self) -> None:
        """Start a new episode; faults that users set without an end stay."""
        overrides = self.faults
        self._next_episode()
        overrides.restart()
        overrides.update(0.0)
        self.faults = overrides
        self._commands.set_faults(self.faults.table)
        self.event("run", "reset")

    def use(self, scenario: Scenario) -> None:
        """Start an episode of another scenario, without the faults that users set."""
        self.scenario = scenario
        self._next_episode()
        self.event("run", f"scenario {scenario.name}, controller {scenario.controller.name}, seed {scenario.seed}")

    def _next_episode(self) -> None:
        self.episode += 1
        self.revision += 1
        live = self.live
        self._begin()
        self.live = live & set(self.robots)

    def go_on(self) -> None:
        """This is a saved state: begin a segment of the episode, in which every agent begins anew."""
        self.episode, self.revision = self.episode + 1, self.revision + 1
        self.resumed.append(self.k)
        self._event_count, self._planned = self._event_count + SKIPPED, []
        if self._tick is not None:  # the sensors measure once per tick
            self._tick = replace(self._tick, episode=self.episode, revision=self.revision, planned=[])
        text = f"the world was lost: segment {len(self.resumed) + 1} goes on from here, every agent begins anew"
        self.event("run", text, "warning")

    def change_fault(self, link: str, changes: Mapping[str, Any], until: float | None) -> None:
        """Set keys of a fault from the next tick on. Raises FaultError."""
        self.faults.change(link, changes, until)
        self._apply_faults()

    def clear_faults(self, link: str) -> None:
        """Remove what users set on a link, or on "all", from the next tick on. Raises FaultError."""
        self.faults.clear(link, self.now)
        self._apply_faults()

    def impose_faults(self, table: Mapping[LinkId, Fault]) -> None:
        """Use exactly these faults from the next tick on: this world repeats another's."""
        self.faults.impose(table)
        self._apply_faults()

    def event(self, kind: Any, text: str, severity: Any = "info") -> None:
        """Add an event to the log."""
        self._event_count += 1
        self.events.append(Event(self._event_count, self.now, kind, text, severity))

    def hear(self, status: Status) -> None:
        """Take an agent's Status."""
        if status.episode == self.episode and status.sender in self.robots:
            self.statuses[status.sender] = status
            if status.link == LinkId.plans_to(status.sender, self.scenario.size):  # a peer may send anything
                self.counts[status.link] = status.counts

    def setup(self) -> Setup:
        """The Setup of now, for agents and displays."""
        return Setup(
            sender=WORLD,
            seq=self.revision,
            stamp=self.now,
            episode=self.episode,
            revision=self.revision,
            scenario=self.scenario.model_dump_json(exclude_unset=True),
            mode=self.mode,
            faults=dict(self.faults.table),
            user_code=user_code(),
        )

    def summary(self, *, warmup: float = 0.0) -> dict[str, Any]:
        """The summary of the episode so far; empty for an endless one."""
        if self.trace is None:
            return {}
        links = {link: self.counts[link] for link in sorted(self.counts)}
        events = [event for event in self.events if event.number > self._earlier_events]
        return {
            **self.trace.summary(links, self.convergence, self.excursions, events, warmup=warmup),
            **self.contacts.summary(),
            "user_code": [code.model_dump(include=SHOWN) for code in user_code_of(self.scenario)],
            "resumed_at": [k * self.scenario.control_interval for k in self.resumed],
            "commands": self.driver.commands if self.driver else [],
            "way_age_s": {str(i): status.way_age for i, status in sorted(self.statuses.items())},
        }

    def state(
        self,
        *,
        seq: int,
        status: RunStatus,
        speed: float = 0.0,
        pace: float = 0.0,
        overruns: int = 0,
        rejected: int = 0,
        waiting_for: Iterable[int] = (),
        dismissed: Iterable[int] = (),
        compare: str = "",
    ) -> State:
        """The State of now; the arguments are what only its process knows."""
        block = self.reference.block(self.k)
        row = self.k - block.first
        centre, poses = block.centre[row, :3], self.plant.poses
        distance, angle = pattern_errors(poses, block.slots[row])
        return State(
            sender=WORLD,
            seq=seq,
            stamp=self.now,
            episode=self.episode,
            revision=self.revision,
            scenario=self.scenario.name,
            controller=self.scenario.controller.name,
            mode=self.mode,
            status=status,
            waiting_for=list(waiting_for),
            dismissed=list(dismissed),
            speed=speed,
            pace=pace,
            overruns=overruns,
            rejected=rejected,
            poses=poses,
            slots=block.slots[row],
            centre=centre,
            distance_errors=distance,
            angle_errors=angle,
            tracking_error=float(tracking_error(poses, centre[:2])),
            contacts=self.contacts.count,
            gap=self.contacts.gap,
            live=sorted(self.live),
            stopped=sorted(self._commands.held),
            faults=dict(self.faults.table),
            events=list(self.events)[-SHOWN_EVENTS:],
            compare=compare,
            resumed=self.resumed,
            driving=self.driver.shown if self.driver else Driving(),
        )
