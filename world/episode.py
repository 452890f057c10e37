"""An episode as the world keeps it: bodies, faults, events and trace; what displays and agents get of it."""

from collections import deque
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from formation.arrays import FloatArray
from formation.link_ids import LinkId
from formation.metrics import pattern_errors, tracking_error, tracking_error_of_some
from formation.pattern import downstream, leader, upstream
from formation.scenario.scenario import Scenario
from formation.scenario.user_code import SHOWN
from network.messages import WORLD, Command, State, Status, Tick
from network.requests import Setup
from network.stretch import Recording
from network.values import Driving, Event, LinkCounts, Mode, RecordWish, RunStatus
from world.bodies.interface import Bodies, Seeing
from world.bodies.own import user_code, user_code_of
from world.bodies.registry import bodies_for
from world.command_links import CommandLinks
from world.driver import Driver
from world.faults import FaultState
from world.interventions import Interventions
from world.measures.contacts import AtLimits, Contacts
from world.measures.convergence import Convergence
from world.measures.ledger import Ledger
from world.measures.trace import Trace
from world.members import Members
from world.sight import Sight

SHOWN_EVENTS, SHOWN_EXCURSIONS = 40, 20
KEPT_EVENTS = 5000


class Episode:
    """Bodies, links to them, faults, events and trace of one episode after the other; world/world.py moves it on."""

    def __init__(self, scenario: Scenario, *, episode: int = 0, endless: bool = False, mode: Mode = "lockstep") -> None:
        """The start of an episode.

        Args:
            scenario: of the run.
            episode: its number, put into every message.
            endless: continue past the duration, if the path is closed; then no trace is kept.
            mode: "lockstep" or "realtime", for displays.
        """
        self.episode, self.mode = episode, mode
        self._endless_wish = endless
        self.revision = 0
        self.events: deque[Event] = deque(maxlen=KEPT_EVENTS)
        self._event_count = 0
        self.given = scenario
        """As every episode begins with it; `scenario` has the shapes that users ordered since as well."""
        self._begin()
        self.event("run", f"scenario {scenario.name}, controller {scenario.controller.name}, seed {scenario.seed}")

    def bodies_for(self, scenario: Scenario) -> Bodies:
        """The bodies of an episode."""
        return bodies_for(scenario)

    def _begin(self) -> None:
        """Begin an episode of the scenario."""
        scenario = self.scenario = self.given
        self.k = 0
        self._earlier_events = self._event_count
        self.resumed: list[int] = []  # ticks of the episode at which a world went on from a saved state
        self.endless = self._endless_wish and scenario.path.endless
        self.plant, self._sight = self.bodies_for(scenario), Sight(scenario)
        self.faults = FaultState(scenario)
        self.faults.update(0.0)
        self.interventions = Interventions(scenario, self.plant)
        self.members = Members(scenario)
        self.away: frozenset[int] = frozenset()  # robots over which the ring is closed
        self.closed_at = 0  # tick from which on it is so
        self.driver = Driver(scenario, forgets=self.endless) if scenario.driven else None
        self.reference = self.driver.reference if self.driver else scenario.reference()
        self.trace = None if self.endless else Trace(scenario, scenario.ticks, self.reference)
        if self.trace:
            self.trace.start(self.plant.poses)
        self.inputs: FloatArray = np.zeros((scenario.size, 2))  # commanded over the tick before
        self.counts: dict[LinkId, LinkCounts] = {}
        self.statuses: dict[int, Status] = {}
        self.live: set[int] = set()
        self.convergence = Convergence()
        self.contacts, self.at_limits = Contacts(scenario.bodies.radii(scenario.size)), AtLimits(scenario)
        self._commands = CommandLinks(scenario)
        self.ledger = Ledger(scenario)
        self._planned: list[int] = []
        self._tick: Tick | None = None
        self._commands.set_faults(self.faults.table)
        self._look()
        self._drive()
        self.members.look(0, ())
        self._close_ring()
        self._note_pushes()

    # ------------------------------------------------------------------ state

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

    # ------------------------------------------------------------------ what happens

    def _drive(self) -> None:
        """The driver's orders for the tick that is computed next."""
        for line in self.driver.begin(self.k) if self.driver else ():
            self.event("drive", line)

    def _look(self) -> None:
        """Count who touches whom."""
        for one, other in self.contacts.look(self.plant.poses):
            self.event("contact", f"robots {one} and {other} touch", "warning")

    def _close_ring(self) -> None:
        """Have the ring closed over the robots that are away, if these are others than before."""
        before, away = self.away, self.members.away
        if away == before:
            return
        self.away, self.closed_at = away, self.k
        self.revision += 1
        self.interventions.ring(self.k, away)
        self.faults.close_over(away)
        if isinstance(self.plant, Seeing):
            self.plant.close_over(away)
        self.faults.update(self.now)
        self._commands.set_faults(self.faults.table)
        if self.trace:
            self.trace.close_over(away)
        for robot in sorted(away - before):
            hears = downstream(robot, self.scenario.size, away)
            text = f"robot {robot} leaves the ring: robot {hears} hears robot {upstream(hears, len(self.robots), away)}"
            self.event("agent", text, "warning")
        for robot in sorted(before - away):
            self.event("agent", f"robot {robot} joins the ring")
        if self.scenario.path.known_to == "leader":
            self._say_who_leads(before)

    def _say_who_leads(self, before: frozenset[int]) -> None:
        """Log it if another robot tells the path than when these were away, or none."""
        follows = self.scenario.path.leader == "next"
        was, now = leader(before, follows=follows), leader(self.away, follows=follows)
        if now in self.away - before:
            self.event("agent", "nobody tells the robots the path: the formation stops", "error")
        elif now != was:
            self.event("agent", f"robot {now} tells the others the path")

    def _keep_ledger(self, commands: Mapping[int, Command]) -> None:
        """Look for excursions after a tick."""
        block = self.reference.block(self.k)
        for line in self.ledger.look(
            self.now,
            self.plant.poses,
            block.slots[self.k - block.first],
            commands=commands,
            faults=self.faults.table,
            disturbances=self.interventions.acting,
            live=self.live,
            away=self.away,
        ):
            self.event("excursion", line, "info" if line.endswith("again") else "warning")

    def _note_pushes(self) -> None:
        """Log the disturbances that begin or end now."""
        for text, begins in self.interventions.update(self.now):
            self.event("push", text, "warning" if begins else "info")

    def event(self, kind: Any, text: str, severity: Any = "info") -> None:
        """Add an event to the log."""
        self._event_count += 1
        self.events.append(Event(self._event_count, self.now, kind, text, severity))

    def hear(self, status: Status) -> None:
        """Take an agent's Status."""
        if status.episode == self.episode and status.sender in self.robots:
            self.statuses[status.sender] = status
            if status.link == LinkId.plans_to(status.sender, self.scenario.size, self.away):  # a peer may send anything
                self.counts[status.link] = status.counts

    # ------------------------------------------------------------------ what is published

    def setup(self) -> Setup:
        """The Setup of now, for agents and displays."""
        return Setup(
            sender=WORLD,
            seq=self.revision,
            stamp=self.now,
            episode=self.episode,
            revision=self.revision,
            scenario=self.given.model_dump_json(exclude_unset=True),
            mode=self.mode,
            faults=dict(self.faults.table),
            changes=[change.model_dump(mode="json", exclude_unset=True) for change in self.interventions.changes],
            away=sorted(self.away),
            closed_at=self.closed_at,
            user_code=user_code(),
        )

    def summary(self, *, warmup: float = 0.0) -> dict[str, Any]:
        """The summary of the episode so far; empty for an endless one."""
        links = {link: self.counts.get(link, LinkCounts()) for link in sorted(self.counts)}
        if self.trace is None:
            return {}
        return {
            **self.trace.summary(links, self.convergence, self.at_limits, self._events_of_episode(), warmup=warmup),
            **self.contacts.summary(),
            **self.ledger.summary(),
            "user_code": [code.model_dump(include=SHOWN) for code in user_code_of(self.scenario)],
            "resumed_at": [k * self.scenario.control_interval for k in self.resumed],
            "commands": self.driver.commands if self.driver else [],
            "way_age_s": {str(i): status.way_age for i, status in sorted(self.statuses.items())},
        }

    def _events_of_episode(self) -> list[Event]:
        return [event for event in self.events if event.number > self._earlier_events]

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
        record: RecordWish = "",
        recording: Recording | None = None,
    ) -> State:
        """The State of now; the arguments are what only its process knows."""
        block = self.reference.block(self.k)
        row = self.k - block.first
        centre: FloatArray = block.centre[row, :3]
        poses = self.plant.poses
        slots, away = block.slots[row], self.away
        distance, angle = pattern_errors(poses, slots, away)
        tracking = tracking_error_of_some(poses, slots, away) if away else tracking_error(poses, centre[:2])
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
            slots=slots,
            centre=centre,
            distance_errors=distance,
            angle_errors=angle,
            tracking_error=float(tracking),
            contacts=self.contacts.count,
            gap=self.contacts.gap,
            live=sorted(self.live),
            stopped=sorted(self._commands.held),
            faults=dict(self.faults.table),
            events=list(self.events)[-SHOWN_EVENTS:],
            compare=compare,
            record=record,
            recording=recording,
            resumed=self.resumed,
            away=sorted(away),
            driving=self.driver.shown if self.driver else Driving(),
            interventions=self.interventions.count,
            excursions=self.ledger.newest(SHOWN_EXCURSIONS),
            excursion_count=self.ledger.count,
            excursion_limit=self.ledger.limit,
            pushes=self.interventions.shown,
        )
