"""The fast engine: world and agents in one process, on a counted clock, through the same links."""

from collections.abc import Callable, Collection
from time import perf_counter
from typing import Any

from agents.agent import Agent
from agents.controllers.interface import Team
from agents.controllers.registry import team_for
from agents.sending import Answer
from formation.errors import ScenarioError
from formation.pattern import place
from formation.scenario.scenario import Scenario
from network.messages import Command, Plan
from world.measures.trace import Trace
from world.world import World

PROGRESS_TICKS = 50


class Simulation:
    """An episode of the scenario, tick by tick."""

    def __init__(self, scenario: Scenario, *, endless: bool = False, team: Team | None = None) -> None:
        """World and agents at t = 0.

        Args:
            scenario: what to simulate.
            endless: continue past the duration, if the path is closed; then no trace is kept.
            team: plans for all robots at once, instead of the scenario's controller.
        """
        self.world = World(scenario, endless=endless)
        self._team = team or team_for(scenario)
        if self._team and scenario.membership.changes:
            raise ScenarioError(f"membership.changes: {scenario.controller.name} plans for all robots, none may leave")
        self.agents = {robot: self._agent(robot) for robot in self.world.robots}
        self.world.live = set(self.agents)
        self._away = self.world.away
        self._heard_by = self._hearers()
        self._revision, self._scenario = -1, self.world.scenario  # a ring that begins closed may have another shape
        self._plans: list[Plan] = []  # of the last tick: they meet the faults of this one, as they do between processes

    def _agent(self, robot: int) -> Agent:
        world = self.world
        member = self._team.member(robot) if self._team else None
        return Agent(world.scenario, robot, episode=world.episode, controller=member, away=world.away)

    def _hearers(self) -> dict[int, list[int]]:
        """By robot, who takes its plans."""
        found: dict[int, list[int]] = {robot: [] for robot in self.agents}
        for robot, agent in self.agents.items():
            for sender in agent.hears:
                found[sender].append(robot)
        return found

    def _close_ring(self) -> set[int]:
        """The ring has changed: the robots that have another place in it, whose agents begin anew."""
        n, before, away = len(self.agents), self._away, self.world.away
        moved = {robot for robot in self.agents if place(robot, n, before) != place(robot, n, away)}
        self._away = away
        self.agents |= {robot: self._agent(robot) for robot in moved}
        self._heard_by = self._hearers()
        return moved

    def _reshape(self, scenario: Scenario, moved: Collection[int]) -> None:
        """Users have changed the shape, or the ring has; agents that begin anew have it already."""
        self._scenario = scenario
        for robot in self.agents.keys() - moved:
            self.agents[robot].reshape(scenario, self.world.k)
        if self._team:
            self._team.reshape(scenario, self.world.k)

    @property
    def plans(self) -> list[Plan]:
        """The plans that were sent at the last tick."""
        return self._plans

    @property
    def trace(self) -> Trace:
        """The trace so far."""
        assert self.world.trace is not None  # only an endless world keeps none
        return self.world.trace

    @property
    def finished(self) -> bool:
        """Whether the scenario's duration is over."""
        return self.world.finished

    def go_on(self) -> None:
        """Begin a segment, as a live run does whose world was lost: every agent begins anew, but who sees all poses."""
        self.world.go_on()
        self._scenario = self.world.scenario
        self.agents = {robot: self._agent(robot) for robot in self.world.robots}
        self._away, self._plans = self.world.away, []
        self._heard_by = self._hearers()

    def step(self) -> dict[int, Answer]:
        """One tick: deliver plans, plan, move. What every agent answered."""
        world, agents = self.world, self.agents
        moved: Collection[int] = ()
        tick = world.tick()
        if tick.revision != self._revision:
            self._revision = tick.revision
            moved = self._close_ring() if world.away != self._away else moved
            for agent in agents.values():
                agent.set_faults(world.faults.table)
            if world.scenario is not self._scenario:
                self._reshape(world.scenario, moved)
        heard_by = self._heard_by
        for plan in self._plans:
            for robot in heard_by[plan.sender]:
                if robot not in moved:
                    agents[robot].receive(plan)
        if self._team:
            self._team.see(tick.seq, world.plant.poses, tick.odometry, world.inputs)
        answers: dict[int, Answer] = {}
        commands: dict[int, Command] = {}
        plans: list[Plan] = []
        for robot, agent in agents.items():
            answers[robot] = answer = agent.step(tick)
            commands[robot] = answer.command
            if answer.plan is not None:
                plans.append(answer.plan)
        self._plans = plans
        if tick.last:
            for agent in agents.values():
                world.hear(agent.status(tick.seq, tick.stamp))
        world.advance(commands)
        return answers

    def simulate(self, progress: Callable[[float], None] | None = None) -> Trace:
        """Simulate to the end; `progress` is called now and then with the simulated time [s]."""
        while not self.finished:
            self.step()
            if progress and self.world.k % PROGRESS_TICKS == 0:
                progress(self.world.now)
        return self.trace


def simulate(
    scenario: Scenario, *, progress: Callable[[float], None] | None = None, warmup: float = 0.0
) -> dict[str, Any]:
    """Simulate the scenario to its end and return the summary (world/measures/trace.py).

    Args:
        scenario: what to simulate.
        progress: called now and then with the simulated time [s].
        warmup: measures start at this simulated time [s].
    """
    began = perf_counter()
    simulation = Simulation(scenario)
    simulation.simulate(progress)
    return summary_of(simulation, perf_counter() - began, warmup)


def summary_of(simulation: Simulation, seconds: float, warmup: float) -> dict[str, Any]:
    """The summary of a simulation that took so long [s]; measures start at `warmup` [s]."""
    return {**simulation.world.summary(warmup=warmup), "engine": "inprocess", "wall_s": seconds}
