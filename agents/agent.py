"""One robot's agent, without any I/O: plans and ticks in, a plan and a command out.

The same Agent runs inside one process on a counted clock and as a process over Zenoh, with the same results.
"""

from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass
from time import perf_counter

import numpy as np

from agents.belief import Belief
from agents.controllers.interface import Controller, Observation, Solution
from agents.controllers.nash import Game
from agents.controllers.pair import Pair
from agents.controllers.registry import controller_for
from formation import unicycle
from formation.arrays import FloatArray
from formation.errors import WireError
from formation.faults import PERFECT, Fault
from formation.links import LinkId
from formation.pattern import upstream
from formation.scenario.registry import spec_of
from formation.scenario.scenario import Scenario
from network.codec import decode, encode
from network.link import Arrival, Link, damaged
from network.messages import Command, LinkCounts, Plan, Status

REMEMBERED_COMMANDS = 1024
"""Own commands kept to carry an old pose forward; 10 s at 100 Hz."""


@dataclass(frozen=True, slots=True, eq=False)
class Answer:
    """An agent's messages at a tick."""

    command: Command
    plan: Plan | None
    """For the downstream neighbour, on a planning tick."""


class Agent:
    """The agent of one robot for one episode."""

    def __init__(
        self, scenario: Scenario, robot: int, *, episode: int = 0, controller: Controller | None = None
    ) -> None:
        """An agent at the start of an episode.

        Args:
            scenario: of the run.
            robot: its number, from 1.
            episode: put into every message; plans with another number are ignored.
            controller: instead of the scenario's own for this robot (agents/controllers/centralised.py).
        """
        self.robot, self.episode = robot, episode
        self.upstream = upstream(robot, scenario.size)
        self.planning = scenario.controller.plan_every
        self._pair = Pair(scenario, robot)
        self._game = Game(scenario, robot, self._pair)
        self._controller = controller or controller_for(scenario, robot, self._pair)
        self._ages = scenario.controller.age_plans
        if self._ages is None:
            self._ages = spec_of(scenario.controller).ages_plans
        self._belief = Belief()
        self._plans: Link[Plan] = Link(scenario.seed, LinkId.plans_to(robot, scenario.size), scenario.link)
        self._poses: Link[FloatArray] = Link(scenario.seed, LinkId.poses_to(robot))
        self._pose: tuple[int, FloatArray] | None = None
        self._commands: deque[tuple[int, float, float]] = deque(maxlen=REMEMBERED_COMMANDS)
        self._last: tuple[int, Solution, FloatArray] | None = None
        self._said: Plan | None = None
        self._heard = -1
        self._corrupt = 0
        self._solves: list[float] = []

    def set_faults(self, faults: Mapping[LinkId, Fault]) -> None:
        """Set the faults of the links to this robot from now on; a link that is not named is perfect."""
        self._plans.fault = faults.get(self._plans.id, PERFECT)
        self._poses.fault = faults.get(self._poses.id, PERFECT)

    @property
    def heard(self) -> int:
        """seq of the newest plan of the upstream neighbour that reached the process; -1 before the first."""
        return self._heard

    def receive(self, plan: Plan) -> None:
        """Take a plan of the upstream neighbour that reached the process, and push it into the faulty link.

        A plan of another episode, of another sender, or one that is not newer is ignored.
        """
        if plan.episode == self.episode and plan.sender == self.upstream and plan.seq > self._heard:
            self._heard = plan.seq
            # Bursts are counted in messages, and there is one every `planning` ticks.
            self._plans.push(plan.seq // self.planning, plan.stamp, plan)

    def step(self, k: int, stamp: float, pose: FloatArray) -> Answer:
        """Answer tick k.

        Args:
            k: number of the tick; grows from call to call.
            stamp: its simulated time [s].
            pose: (3,) measured at this tick [m, m, rad].
        """
        for arrival in self._plans.pop(stamp):
            try:
                self._belief.receive(_read(arrival))
            except WireError:
                self._corrupt += 1
        age = self._belief.seconds_old(stamp)
        own = self._own_pose(k, stamp, pose)
        if own is None:  # a robot that does not know its pose does not move
            return Answer(Command(self.robot, k, stamp, self.episode, 0.0, 0.0, age, False, 0.0), None)
        plan = None
        solve = 0.0
        if k % self.planning == 0 or self._last is None:
            began = perf_counter()
            solution = self._plan(k, stamp, own)
            solve = perf_counter() - began
            self._solves.append(solve)
            plan = self._said = Plan(
                self.robot,
                k,
                stamp,
                self.episode,
                own,
                self._pair.interval,
                solution.inputs,
                solution.lag,
                solution.lag_rate,
            )
        v, omega = self._input(k)
        self._commands.append((k, v, omega))
        return Answer(
            Command(self.robot, k, stamp, self.episode, v, omega, age, plan is not None, solve, self._converged), plan
        )

    def status(self, k: int, stamp: float, *, missed: int = 0, rejected: int = 0, pid: int = 0) -> Status:
        """Its Status at tick k, which it has just answered; the arguments are what only its process knows."""
        solve = sum(self._solves) / len(self._solves) if self._solves else 0.0
        self._solves.clear()
        return Status(
            sender=self.robot,
            seq=k,
            stamp=stamp,
            episode=self.episode,
            link=self._plans.id,
            age=self._belief.seconds_old(stamp),
            plan=self._said,
            held=self._belief.plan,
            counts=self.counts(),
            solve=solve,
            missed=missed,
            gap=self._gap(k, stamp),
            rejected=rejected,
            pid=pid,
            converged=self._converged,
        )

    @property
    def _converged(self) -> bool:
        """Whether the newest plan is the solver's, not a fallback."""
        return self._last is None or self._last[1].converged

    def counts(self) -> LinkCounts:
        """Counts of the plans sent to this robot."""
        counts = self._plans.counts
        return LinkCounts(
            sent=counts.sent,
            delivered=counts.delivered,
            lost=counts.lost,
            late=self._belief.late,
            corrupt=self._corrupt,
            duplicated=counts.duplicated,
            in_flight=counts.in_flight,
        )

    def _plan(self, k: int, stamp: float, own: FloatArray) -> Solution:
        slot, tail = self._pair.slot(k, 1)
        aged = self._belief.aged(stamp, slot, tail) if self._ages else self._belief.as_if_fresh(slot, tail)
        solution = self._controller.plan(Observation(k, own, aged))
        self._last = (k, solution, own)
        return solution

    def _input(self, k: int) -> tuple[float, float]:
        """The input of the last plan for tick k."""
        assert self._last is not None
        made, solution, _ = self._last
        inputs = solution.inputs
        j = min((k - made) // self._pair.stride, len(inputs) - 1)
        return float(inputs[j, 0]), float(inputs[j, 1])

    def _own_pose(self, k: int, stamp: float, measured: FloatArray) -> FloatArray | None:
        """The own pose: the newest measurement that was delivered, carried forward along the own commands."""
        if self._poses.transparent:
            self._pose = (k, measured)
            return measured
        self._poses.push(k, stamp, measured)
        for arrival in self._poses.pop(stamp):
            if arrival.damage is None and (self._pose is None or arrival.seq > self._pose[0]):
                self._pose = (arrival.seq, arrival.message)
        if self._pose is None:
            return None
        x, y, theta = self._pose[1]
        for at, v, omega in self._commands:
            if at >= self._pose[0]:
                x, y, theta = unicycle.step(x, y, theta, v, omega, self._pair.tick)
        return np.array([x, y, theta])

    def _gap(self, k: int, stamp: float) -> float:
        if self._last is None or self._last[0] != k:
            return 0.0
        _, solution, own = self._last
        slot, tail = self._pair.slot(k, 1)
        other = self._belief.aged(stamp, slot, tail)
        poses = np.concatenate([own, other.pose])
        return self._game.gap(k, poses, np.hstack([solution.inputs, other.inputs]))


def _read(arrival: Arrival[Plan]) -> Plan:
    """The plan that arrived. Raises WireError if its bytes were damaged."""
    if arrival.damage is None:
        return arrival.message
    return decode(Plan, damaged(encode(arrival.message), arrival.damage))
