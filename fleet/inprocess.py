"""The fast engine: world and agents in one process, on a counted clock, through the same links."""

from collections.abc import Callable
from time import perf_counter
from typing import Any

from agents.agent import Agent
from formation.pattern import downstream
from formation.scenario import Scenario
from network.messages import Plan
from world.world import World

PROGRESS_TICKS = 50


def fly(scenario: Scenario, *, progress: Callable[[float], None] | None = None, warmup: float = 0.0) -> dict[str, Any]:
    """Fly the scenario to its end and return the summary (world/trace.py).

    Args:
        scenario: what is flown.
        progress: called now and then with the simulated time [s].
        warmup: measures start at this simulated time [s].
    """
    began = perf_counter()
    world = World(scenario)
    agents = {robot: Agent(scenario, robot, epoch=world.epoch) for robot in world.robots}
    world.live = set(agents)
    revision = -1
    plans: list[Plan] = []  # of the last tick: they meet the faults of this one, as they do between processes
    while not world.finished:
        tick = world.tick()
        if tick.revision != revision:
            revision = tick.revision
            for agent in agents.values():
                agent.set_faults(world.faults.table)
        for plan in plans:
            agents[downstream(plan.sender, len(agents))].receive(plan)
        answers = {robot: agent.step(tick.seq, tick.stamp, tick.poses[robot - 1]) for robot, agent in agents.items()}
        if tick.last:
            for agent in agents.values():
                world.hear(agent.status(tick.seq, tick.stamp))
        plans = [answer.plan for answer in answers.values() if answer.plan is not None]
        world.advance({robot: answer.command for robot, answer in answers.items()})
        if progress and tick.seq % PROGRESS_TICKS == 0:
            progress(world.now)
    summary = world.summary(warmup=warmup)
    return {**summary, "engine": "inprocess", "wall_s": perf_counter() - began}
