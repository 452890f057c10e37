"""One agent of a record anew, perhaps with another controller: the same measurements, the same plans of its neighbours.

What the robot then would have done is compared with what it did; its body goes where it went. In lockstep all that the
agent got follows from simulating the record again; in real time it is in a record of full detail.
"""

from collections import deque
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from agents.agent import Agent
from formation.errors import EchelonError, ScenarioError
from formation.faults import Fault
from formation.formation_spec import Change
from formation.link_ids import LinkId
from formation.pattern import place
from formation.scenario.registry import check_live, check_name
from formation.scenario.reshaping import closing, reshaped
from formation.scenario.scenario import Scenario
from network.codec import decode
from network.messages import Command, Plan, Tick
from records.cdr import Fields
from records.record import Record, RecordedEpisode, RecordedOrder
from records.scanning import Message, Note, scan
from runtime.verification import check_version, scenario_of, shadow_of, table_of
from world.run_control import with_controller


class Moment(NamedTuple):
    """A tick as an agent has it."""

    scenario: Scenario
    tick: Tick
    plans: list[Plan]
    """That came in since the tick before."""
    faults: Mapping[LinkId, Fault]
    away: frozenset[int]
    """Robots over which the ring is closed."""
    command: Command | None
    """What the robot was commanded at this tick."""


@dataclass(frozen=True, slots=True)
class Compared:
    """What came of it; v [m/s], omega [rad/s]."""

    ticks: int
    """At which both commanded something."""
    first: float | None
    """Simulated time of the first command that differs [s]; None if none does."""
    largest: tuple[float, float]
    """Difference in v and in omega."""
    rms: tuple[float, float]
    failures: int
    """Ticks at which the new agent's solver did not converge, or it stood."""


def rerun(record: Record, robot: int, controller: str = "", number: int = -1) -> Compared:
    """Run the agent of one robot anew.

    Args:
        record: as it was read.
        robot: its number.
        controller: instead of the one that it had.
        number: of the episode, from 0; negative: counted from the last one.

    Raises:
        EchelonError: the record does not hold what is needed, or there is no such robot or controller.
    """
    check_version(record)
    if not -len(record.episodes) <= number < len(record.episodes):
        raise EchelonError(f"expected one of {len(record.episodes)} episodes in {record.path}; got {number}")
    episode = record.episodes[number]
    scenario = scenario_of(episode)
    if not 1 <= robot <= scenario.size:
        raise EchelonError(f"expected a robot of the scenario, 1 to {scenario.size}; got {robot}")
    wanted = controller or scenario.controller.name
    check_name(wanted)
    check_live(wanted)
    if episode.mode == "lockstep":
        return _compare(_simulated(episode, robot), robot, wanted)
    if record.about.get("detail") != "full":
        raise EchelonError(
            f"expected a record of --detail full, or of a lockstep run; {record.path} is of a {episode.mode} run and "
            "holds no plans"
        )
    return _compare(_recorded(record, episode, robot), robot, wanted)


def _simulated(episode: RecordedEpisode, robot: int) -> Iterator[Moment]:
    """The ticks of a lockstep episode, up to the first at which an agent was absent or began anew."""
    shadow = shadow_of(episode)
    world, plans = shadow.world, list[Plan]()
    absent = next((order.tick for order in episode.sorted_orders if order.kind == "agents"), None)
    last = min(tick for tick in (episode.ticks[-1], absent, *episode.resumed[:1]) if tick is not None)
    while shadow.k < last:
        shadow.begin_tick()
        tick, scenario, faults, away = world.tick(), world.scenario, dict(world.faults.table), world.away
        shadow.step()
        yield Moment(scenario, tick, plans, faults, away, shadow.answers[robot].command)
        plans = [answer.plan for answer in shadow.answers.values() if answer.plan is not None]


def _recorded(record: Record, episode: RecordedEpisode, robot: int) -> Iterator[Moment]:
    """The ticks of an episode as they went over the wire."""
    formation, found = _Formation(scenario_of(episode)), _wire(record, episode)
    orders = [order for order in episode.sorted_orders if order.kind == "faults"]
    changes = deque(order for order in episode.sorted_orders if order.kind in ("ring", "shape"))
    held: Moment | None = None
    plans: list[Plan] = []
    for message in found:
        if isinstance(message, Plan):
            plans.append(message)
        elif isinstance(message, Command):
            if held is not None and message.sender == robot and message.seq == held.tick.seq:
                held = held._replace(command=message)
        else:
            if held is not None:
                yield held
            while changes and changes[0].tick <= message.seq:
                formation.take(changes.popleft(), episode.interval)
            table = next((table_of(order) for order in reversed(orders) if order.tick <= message.seq), {})
            held, plans = Moment(formation.scenario, message, plans, table, formation.away, None), []
    if held is not None:
        yield held


class _Formation:
    """The scenario with the shapes that it has had since, and who is away, as the world of a record had them."""

    def __init__(self, scenario: Scenario) -> None:
        self.scenario, self.away = scenario, frozenset[int]()
        self._given, self._changes = scenario, list[Change]()

    def take(self, order: RecordedOrder, interval: float) -> None:
        """A change of the ring or of the shape; a tick lasts so long [s]."""
        if order.kind == "shape":
            change = Change.model_validate(order.value)
        else:
            self.away = frozenset(order.value["away"])
            if self.scenario.membership.shape == "keep":
                return
            now = order.tick * interval
            try:
                change = closing(self.scenario, now - self.scenario.reference().lag(now), self.away)
                reshaped(self._given, [*self._changes, change])
            except ScenarioError:
                return  # the robots kept their places
        self._changes.append(change)
        self.scenario = reshaped(self._given, self._changes)


def _wire(record: Record, episode: RecordedEpisode) -> Iterator[Tick | Plan | Command]:
    kinds: dict[str, type[Tick] | type[Plan] | type[Command]] = {"tick": Tick, "plan": Plan, "command": Command}
    inside = False
    for item in scan(record.path):
        if isinstance(item, Note) and item.name == "episode":
            inside = item.values["number"] == str(episode.number)
        if inside and isinstance(item, Message) and item.topic.startswith("/wire/"):
            fields = Fields(item.data)
            key = fields.text()
            message: Tick | Plan | Command = decode(kinds[key.rpartition("/")[2]], fields.octets())
            if message.episode == episode.number:
                yield message


def _compare(moments: Iterator[Moment], robot: int, controller: str) -> Compared:
    agent: Agent | None = None
    before: Moment | None = None
    deaf_until = -1  # an agent whose place in the ring has changed begins anew, and hears plans from then on
    differences, times, failures = [], [], 0
    for moment in moments:
        scenario = _under(moment.scenario, controller)
        n, old = scenario.size, agent
        if agent is None or before is None or place(robot, n, moment.away) != place(robot, n, before.away):
            agent = Agent(scenario, robot, episode=moment.tick.episode, away=moment.away)
            deaf_until = -1 if old is None else moment.tick.seq
        elif moment.scenario is not before.scenario:
            agent.reshape(scenario, moment.tick.seq)
        if agent is not old or before is None or moment.faults != before.faults:
            agent.set_faults(moment.faults)
        for plan in moment.plans:
            if plan.seq >= deaf_until:
                agent.receive(plan)
        answer = agent.step(moment.tick).command
        failures += not answer.converged or bool(answer.failure)
        if moment.command is not None:
            differences.append((answer.v - moment.command.v, answer.omega - moment.command.omega))
            times.append(moment.tick.stamp)
        before = moment
    if not differences:
        raise EchelonError(f"expected commands of robot {robot} in the record; there are none")
    apart = np.array(differences)
    first = next((time for time, pair in zip(times, differences, strict=True) if any(pair)), None)
    largest, rms = np.abs(apart).max(axis=0).tolist(), np.sqrt((apart**2).mean(axis=0)).tolist()
    return Compared(len(apart), first, (largest[0], largest[1]), (rms[0], rms[1]), failures)


def _under(scenario: Scenario, controller: str) -> Scenario:
    return scenario if controller == scenario.controller.name else with_controller(scenario, controller)
