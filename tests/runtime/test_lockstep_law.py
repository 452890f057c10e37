"""The central law, without processes: whatever the bus does, lockstep is what one process computes, to the last bit.

World and agents are the very nodes of the processes; they run on the memory bus, on a time of the test's own.
"""

import os
from dataclasses import replace
from functools import cache, partial
from typing import Any

import pytest
from hypothesis import Phase, given, settings
from hypothesis import strategies as st

from agents.agent import Agent
from formation.scenario.files import load
from formation.scenario.lockstep import Lockstep
from formation.scenario.scenario import Scenario
from network.control import Pause, Reset, Start
from network.messages import Plan
from runtime import inprocess
from tests.memory_run import MemoryRun, Weather
from world.presence import AgentPresence
from world.rate import RunningTime
from world.run_control import RunControl
from world.states import Phase as WorldPhase
from world.world import World

ROBOTS = (1, 2, 3)
SETTINGS = (
    "duration=0.15",
    "noise={slip=0.2, gyro=0.2, position=0.001, heading=0.01}",
    "faults=[{link='world->2', loss=0.2}, {at=0.04, until=0.1, link='1->2', cut=true}, {link='3->world', loss=0.2}]",
    "link={latency=0.02, jitter=0.01, loss=0.2, corrupt=0.1}",
)
EXAMPLES = int(os.environ.get("ECHELON_EXAMPLES", "20"))
"""Of each law; tried with 1000 too."""


@cache
def scenario(plan_every: int = 1) -> Scenario:
    return load("triangle-circle", [*SETTINGS, f"controller.plan_every={plan_every}"])


@cache
def expected(plan_every: int = 1) -> str:
    """The hash of the trajectory that one process computes."""
    return str(inprocess.simulate(scenario(plan_every))["trajectory_sha256"])


moments = st.integers(0, 40).map(lambda ms: 1e-3 * ms)
"""A run in fine weather is over after some 0.04 s."""
fates = st.one_of(
    st.just(()),
    st.tuples(st.floats(0.0, 3.0)),
    st.tuples(st.floats(0.0, 0.02), st.floats(0.0, 3.0)),
)
weathers = st.builds(
    Weather,
    seed=st.integers(0, 2**16),
    lost=st.sampled_from([0.0, 0.1, 0.4]),
    doubled=st.sampled_from([0.0, 0.3]),
    delayed=st.sampled_from([0.0, 0.1, 0.5]),
    longest=st.sampled_from([0.01, 0.3, 3.0]),
    until=st.sampled_from([0, 100, 400]),
    letters=st.dictionaries(st.integers(0, 200), fates, max_size=10),
)


def outage(run: MemoryRun, length: float, delays: tuple[float, ...]) -> None:
    """The router goes and comes back; every process finds it again in its own time."""
    run.router_goes()
    run.at(length, lambda: run.router_returns(delays))


def silence(run: MemoryRun, robots: tuple[int, ...], length: float) -> None:
    """Agents hang; their tokens stay."""
    run.suspend(*robots)
    run.at(length, lambda: run.resume(*robots))


def standstill(run: MemoryRun, length: float, delays: tuple[float, ...]) -> None:
    """Everybody is suspended, the router too: afterwards every lease is over, and every link is made anew."""
    run.run(1e-3, lambda: run.finished)  # a world that has not looked at its clock yet cannot have stood still
    run.suspend(*ROBOTS, world=True)

    def go_on() -> None:
        run.resume(*ROBOTS, world=True)
        for bus, delay in zip(list(run.hub.buses), delays, strict=False):
            run.at(delay, partial(run.hub.disconnect, bus))
            run.at(2.0 * delay + 0.05, partial(run.connect, bus))

    run.at(length, go_on)


def forge(run: MemoryRun, ahead: int, times: int) -> None:
    """A tick that is not the world's, far ahead, and doubled."""
    tick = run.world.tick()
    seq = tick.seq + ahead
    forged = replace(tick, seq=seq, stamp=seq * run.world.scenario.control_interval)
    for _ in range(times):
        run.forge_tick(forged)


delays = st.tuples(*[st.floats(0.0, 1.0)] * 5)
silences = st.sampled_from([0.05, 2.0, 6.0, 9.0, 12.0])
"""[s]; all are below the patience."""
incidents = st.one_of(
    st.tuples(st.just(outage), st.floats(0.001, 5.0), delays),
    st.tuples(st.just(silence), st.sets(st.sampled_from(ROBOTS), min_size=1).map(tuple), silences),
    st.tuples(st.just(standstill), st.floats(0.6, 30.0), delays),
    st.tuples(st.just(forge), st.integers(3, 2**40), st.integers(1, 2)),
)
histories = st.lists(st.tuples(moments, incidents), max_size=3)


def play(run: MemoryRun, history: list[tuple[float, tuple[Any, ...]]]) -> None:
    """Have each incident happen at its moment, and the next not before that."""
    for moment, (act, *arguments) in history:
        run.run(moment, lambda: run.finished)
        act(run, *arguments)


law = settings(max_examples=EXAMPLES, deadline=None, derandomize=True, database=None)
"""The same examples each time."""
search = settings(law, max_examples=200, phases=[Phase.generate])
"""For a fault that must be found."""


crews = st.sampled_from([(), (1, 2), ROBOTS])
"""Robots whose agents share a process."""


@law
@given(weathers, histories, st.sampled_from([1, 3]), crews)
def test_whatever_the_bus_does_the_trajectory_is_that_of_one_process(
    weather: Weather, history: list[Any], plan_every: int, crew: tuple[int, ...]
) -> None:
    whatever_the_bus_does(weather, history, plan_every, crew)


def whatever_the_bus_does(weather: Weather, history: list[Any], plan_every: int, crew: tuple[int, ...]) -> None:
    run = MemoryRun(scenario(plan_every), weather, crew=crew)
    play(run, history)
    assert run.finish() == expected(plan_every)


@settings(law, max_examples=EXAMPLES // 4)
@given(weathers, histories, crews)
def test_a_ring_that_closes_and_opens_is_that_of_one_process(
    weather: Weather, history: list[Any], crew: tuple[int, ...]
) -> None:
    run = MemoryRun(shrinking(), weather, crew=crew)
    play(run, history)
    assert run.finish() == str(inprocess.simulate(shrinking())["trajectory_sha256"])


@cache
def shrinking() -> Scenario:
    """Of three, one leaves and joins again, then another leaves."""
    changes = "membership.changes=[{robot=2, leave=0.04, join=0.09}, {robot=3, leave=0.11}]"
    return load("triangle-circle", [*SETTINGS, changes])


@pytest.mark.parametrize("bodies", ["epuck", "turtlebot3", "camera"])
@pytest.mark.parametrize("path", ["{kind='circle'}", "{kind='circle', known_to='leader', leader='next'}"])
def test_a_ring_that_begins_closed_in_another_shape_is_that_of_one_process(bodies: str, path: str) -> None:
    """Where robots start is part of what estimators believe; an agent that is replaced begins in that shape too."""
    begun = begins_closed(bodies, path)
    assert MemoryRun(begun).finish() == inprocess.simulate(begun)["trajectory_sha256"]
    run = MemoryRun(begun)
    run.run(5.0, lambda: run.world.k == 12)
    run.kill_agent(3)
    run.at(0.01, partial(run.start_agent, 3))
    assert run.finish() == in_one_process(run)


def begins_closed(bodies: str, path: str) -> Scenario:
    """Of four, one has left before the first tick, and the others have taken the shape of three."""
    away = "membership={shape='close', changes=[{robot=1, leave=0}]}"
    formation = "formation.robots=4"
    return load("ring-16", ["duration=0.4", f"path={path}", formation, away, f"bodies={bodies}"])


def test_robots_that_are_told_the_path_drive_alike_in_both_engines() -> None:
    """Told, cut off for longer than the preview, and told again: the same bits."""
    fault = "faults=[{at=0.1, until=4.4, link='1->2', cut=true}, {link='2->3', latency=0.05, loss=0.1}]"
    told = load("follow-the-leader", ["duration=4.6", fault])
    assert told.path.known_to == "leader"
    run = MemoryRun(told, Weather(), crew=(2, 3))
    assert run.finish() == inprocess.simulate(told)["trajectory_sha256"]


@law
@given(weathers, histories, st.lists(moments, min_size=1, max_size=3), crews)
def test_an_episode_begun_anew_is_a_whole_one(
    weather: Weather, history: list[Any], resets: list[float], crew: tuple[int, ...]
) -> None:
    run = MemoryRun(scenario(), weather, crew=crew)
    play(run, history)
    for moment in resets:
        run.run(moment, lambda: run.finished)
        begin_anew(run)
    assert run.finish() == expected()


def begin_anew(run: MemoryRun) -> None:
    episode = run.world.episode
    run.ask_until(Reset(), lambda: run.world.episode != episode)


@law
@given(weathers, st.sets(st.sampled_from(ROBOTS), min_size=1), st.floats(1.0, 9.0), moments)
def test_no_silence_is_for_ever(weather: Weather, robots: set[int], length: float, moment: float) -> None:
    no_silence_is_for_ever(weather, robots, length, moment)


def no_silence_is_for_ever(weather: Weather, robots: set[int], length: float, moment: float) -> None:
    """Agents are silent beyond the patience: declared failed, let in again; and a reset begins a whole episode."""
    run = MemoryRun(scenario().model_copy(update={"lockstep": Lockstep(patience=1.0)}), weather)
    run.run(moment, lambda: run.finished)
    silence(run, tuple(robots), length)
    run.finish(60.0)
    run.run(length + weather.longest)
    run.hub.fate = Weather()
    begin_anew(run)
    assert run.finish(60.0) == expected()


def pause(run: MemoryRun, length: float) -> None:
    """A user stops the run for a while: nobody is lost while a tick is out."""
    run.ask_until(Pause(), lambda: run.node.phase is WorldPhase.HOLD)
    run.at(length, lambda: run.ask_until(Start(), lambda: run.node.phase is not WorldPhase.HOLD))


def replaced(weather: Weather, before: tuple[Any, ...] | None, restarts: list[tuple[float, set[int], float]]) -> None:
    """The run is that of one process in which the same robots took part in the same ticks."""
    run = MemoryRun(scenario(), weather)
    if before is not None:
        moment, (act, *arguments) = before
        run.run(moment, lambda: run.finished)
        act(run, *arguments)
    for moment, robots, absence in restarts:
        run.run(moment, lambda: run.finished)
        for robot in [robot for robot in sorted(robots) if run.agents[robot].alive]:
            run.kill_agent(robot)
            run.at(absence, partial(run.start_agent, robot))
    assert run.finish(28.0) == in_one_process(run)  # before the patience with anybody is over


absences = st.sampled_from([0.0, 0.01, 0.3, 2.0])
"""Of an agent that is replaced [s]: it may be back before anybody has noticed."""
crews_of_restarts = st.lists(
    st.tuples(moments, st.sets(st.sampled_from(ROBOTS), min_size=1), absences), min_size=1, max_size=3
)
befores = st.none() | st.tuples(
    moments,
    st.one_of(
        st.tuples(st.just(standstill), st.floats(0.6, 9.0), delays),
        st.tuples(st.just(outage), st.floats(0.001, 5.0), delays),
        st.tuples(st.just(pause), st.floats(0.01, 3.0)),
    ),
)


@law
@given(weathers, befores, crews_of_restarts)
def test_an_agent_that_is_replaced_joins_cold_at_a_named_tick(
    weather: Weather, before: Any, restarts: list[tuple[float, set[int], float]]
) -> None:
    """Whatever was before, nobody waits for what the lost had sent."""
    replaced(weather, before, restarts)


@settings(law, max_examples=EXAMPLES // 4)
@given(
    weathers,
    st.lists(st.tuples(moments, moments, st.floats(0.0, 2.0)), min_size=1, max_size=3),
    st.lists(st.tuples(moments, st.sampled_from(ROBOTS), st.floats(0.3, 2.0)), max_size=1),
)
def test_a_world_that_is_replaced_goes_on_from_what_was_saved(
    weather: Weather, deaths: list[tuple[float, float, float]], restarts: list[tuple[float, int, float]]
) -> None:
    """The run is that of one process in which every agent begins anew at the tick of each saved state."""
    run = MemoryRun(scenario(), weather)
    for moment, robot, absence in restarts:
        run.run(moment, lambda: run.finished)
        run.kill_agent(robot)
        run.at(absence, partial(run.start_agent, robot))
    for until_saved, until_killed, absence in deaths:
        run.run(until_saved, lambda: run.finished)
        run.save_world()
        saved, episode = run.world.k, run.world.episode
        run.run(until_killed, lambda: run.finished)
        run.replace_world(absence)
        run.run(absence + 0.01)
        assert run.world.episode == episode + 1
        assert run.world.resumed[-1] == saved
    hashed = run.finish()
    assert len(run.world.resumed) == len(deaths)
    assert hashed == in_one_process(run)


def in_one_process(run: MemoryRun) -> str:
    """The hash that world and agents compute when they are called in turn, with who took part as in this run."""
    world = World(run.world.given, episode=run.world.episode - len(run.world.resumed))
    lives = [(process.robot, process.steps) for process in [*run.dead, *run.agents.values()]]
    agents: dict[int, Agent] = {}
    plans: dict[int, Plan] = {}
    sent: dict[int, int] = {}
    """By robot, the life that has sent its plan."""
    while not world.finished:
        for _ in range(run.world.resumed.count(world.k) - world.resumed.count(world.k)):
            world.go_on()
            agents.clear()
            plans.clear()
        tick, counted, answers = world.tick(), run.counted[world.k], {}
        here = {robot: life for life, (robot, steps) in enumerate(lives) if (tick.episode, tick.seq) in steps}
        for life, (robot, steps) in enumerate(lives):
            step = steps.get((tick.episode, tick.seq))
            if step is None:
                continue
            agent = agents.setdefault(life, Agent(world.scenario, robot, episode=world.episode, away=world.away))
            agent.set_faults(world.faults.table)
            plan = plans.get(agent.upstream)
            if step and plan is not None:
                agent.receive(plan)
            elif plan is not None:
                assert not step
                is_gone = agent.upstream not in counted or here[agent.upstream] != sent[agent.upstream]
                assert is_gone, "only a plan whose sender is gone is done without"
            answers[robot] = agent.step(tick)
        plans, sent = {robot: plan for robot in counted if (plan := answers[robot].plan) is not None}, here
        world.advance({robot: answers[robot].command for robot in sorted(counted)})
    return str(world.summary()["trajectory_sha256"])


# ---------------------------------------------------------------------- what the law finds


def _five_seconds_of_silence_are_enough(patch: pytest.MonkeyPatch) -> None:
    impatient = cache(lambda plan_every=1: patient(plan_every).model_copy(update={"lockstep": Lockstep(patience=5.0)}))
    patient = scenario
    patch.setattr(f"{__name__}.scenario", impatient)


def _nobody_calls_those_who_were_silent(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(RunControl, "calling", False)
    patch.setattr(AgentPresence, "recall", lambda self: None)


def _any_tick_is_believed(patch: pytest.MonkeyPatch) -> None:
    patch.setattr("agents.node.is_believable", lambda *_, **__: True)


def _a_standstill_counts_as_silence(patch: pytest.MonkeyPatch) -> None:
    def look(self: RunningTime, now: float) -> float:
        self.now = now
        return 0.0

    patch.setattr(RunningTime, "look", look)


def _another_process_is_the_same_agent(patch: pytest.MonkeyPatch) -> None:
    appear = AgentPresence.appear
    patch.setattr(AgentPresence, "appear", lambda self, robot, session: appear(self, robot))


def _plans_of_the_lost_are_waited_for(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(World, "forget_plans", lambda self, robots: None)


WHATEVER = (whatever_the_bus_does, (weathers, histories, st.just(1), st.just(())))
REPLACED = (replaced, (weathers, befores, crews_of_restarts))
SILENCE = (no_silence_is_for_ever, (weathers, st.just(set(ROBOTS)), st.floats(1.0, 9.0), moments))


@pytest.mark.parametrize(
    ("fault", "law"),
    [
        (_five_seconds_of_silence_are_enough, WHATEVER),
        (_nobody_calls_those_who_were_silent, SILENCE),
        (_any_tick_is_believed, WHATEVER),
        (_a_standstill_counts_as_silence, WHATEVER),
        (_another_process_is_the_same_agent, REPLACED),
        (_plans_of_the_lost_are_waited_for, REPLACED),
    ],
)
def test_a_fault_put_back_is_found(fault: Any, law: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    fault(monkeypatch)
    check, strategies = law
    with pytest.raises(AssertionError):
        search(given(*strategies)(check))()  # type: ignore[no-untyped-call]
