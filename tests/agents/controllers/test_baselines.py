"""What `nash` is compared with: own slots only, a consensus law, and the joint optimum of all robots as the bound."""

# mypy: disable-error-code="arg-type, call-arg, no-any-return, operator, var-annotated"
# (unpacked poses, numpy scalars and shapes; what strict typing of numpy makes of test arithmetic)

import math
from typing import Any, cast
from unittest.mock import MagicMock

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from agents.agent import Agent
from agents.controllers.centralised import Team
from agents.controllers.consensus import Consensus
from agents.controllers.pair_game import weights as nash_weights
from agents.controllers.task import Task
from agents.kernels.consensus import roll_law
from agents.kernels.lq import cost, optimise
from agents.kernels.pair_cost import cost as pair_cost
from agents.kernels.pair_cost import ring_weights
from dashboard.panels.run import RunPanel
from dashboard.scenario_list import ScenarioList
from formation.arrays import FloatArray
from formation.errors import ScenarioError
from formation.pattern import upstream
from formation.scenario.files import load, parse
from formation.scenario.registry import IN_PROCESS, live, names
from formation.scenario.scenario import Scenario
from formation.unicycle import step
from network.control import UseController, UseScenario
from runtime.compose import compose_file
from runtime.inprocess import Simulation, simulate
from runtime.launcher import LiveRun
from tests import builders
from world.run_control import RunControl
from world.world import World

DT = 0.1
Q, R = (1.0, 1.0, 0.01, 1.0, 0.01, 0.01), (0.01, 0.01)
LIMITS = np.array([0.5, 2.0])
NOTHING_YET = np.zeros((3, 2))
"""What three robots that cannot be late do and are told [m/s, rad/s]."""
BASELINES = ("virtual_structure", "consensus", "centralised")
DISORDER = "robots.start_noise={position=0.02, heading=0.1}"
NOISE = "noise={slip=0.2, gyro=0.2, position=0.001, heading=0.01}"
STUCK = "disturbances=[{robot=2, at=0.5, until=2.5, drive=0.0}]"
SEEDS = st.integers(0, 2**32)


def scenario(controller: str, *changes: str, name: str = "triangle-circle") -> Scenario:
    return load(name, [f"controller.name={controller}", *changes])


def sha(*arguments: Any, **more: Any) -> str:
    return str(simulate(scenario(*arguments, **more))["trajectory_sha256"])


def worst(summary: dict[str, Any], figure: str) -> float:
    """Of all robots' l_e [mm]."""
    return 1e3 * max(abs(robot["distance_error_m"][figure]) for robot in summary["robots"].values())


# ---------------------------------------------------------------- all of them


@pytest.mark.parametrize("controller", BASELINES)
@pytest.mark.parametrize("name", ["circle", "triangle-circle"])
def test_a_baseline_brings_a_disordered_formation_into_order_on_a_circle(controller: Any, name: Any) -> None:
    summary = simulate(scenario(controller, "duration=16", DISORDER, "seed=3", name=name), warmup=14.0)
    start = simulate(scenario(controller, "duration=0.01", DISORDER, "seed=3", name=name))
    assert worst(start, "max") > 10.0
    assert worst(summary, "rms") < worst(start, "max") / 10
    assert summary["tracking_error_m"]["rms"] < 2e-3


@pytest.mark.parametrize("controller", BASELINES)
def test_a_baseline_that_stands_in_its_slots_stays_there(controller: Any) -> None:
    summary = simulate(scenario(controller, "duration=2", name="circle"))
    assert worst(summary, "max") < 1e-3
    assert summary["tracking_error_m"]["max"] < 1e-5


@pytest.mark.parametrize("controller", BASELINES)
def test_limits_are_kept_from_a_wild_start(controller: Any) -> None:
    simulation = Simulation(scenario(controller, "duration=1", "robots.start_noise={position=0.5, heading=2}"))
    simulation.simulate()
    inputs = np.abs(simulation.trace.inputs)
    assert (inputs <= LIMITS + 1e-12).all()
    assert (inputs.max(axis=(0, 1)) > 0.99 * LIMITS).any()  # they were needed


@pytest.mark.parametrize("controller", BASELINES)
def test_relabelling_the_robots_permutes_the_trajectories(controller: Any) -> None:
    base = load("triangle-circle")
    offsets = np.array([[0.08, 0.0], [-0.05, 0.06], [-0.03, -0.06]])  # scalene: no symmetry makes the law trivial

    def trajectory(turn: int) -> FloatArray:
        raw = {
            "name": "ring",
            "duration": 3.0,
            "path": {"kind": "circle"},
            "formation": {"offsets": np.roll(offsets, turn, axis=0).tolist()},
            "robots": {"poses": np.roll(np.array(base.robots.poses), turn, axis=0).tolist()},
            "controller": {"name": controller},
        }
        simulation = Simulation(parse(raw))
        simulation.simulate()
        return simulation.trace.poses

    here, there = trajectory(0), trajectory(1)
    # Sums in another order; where steps end at a tolerance, by at most that much over the episode.
    np.testing.assert_allclose(there, np.roll(here, 1, axis=1), atol=1e-6)
    assert np.abs(there - here).max() > 0.01


# ---------------------------------------------------------------- virtual_structure


@pytest.mark.parametrize(
    "faults", ["link.cut=true", "link.latency=0.5", "link={loss=0.5, burst=5}", "link.corrupt=0.5"]
)
def test_messages_mean_nothing_to_a_virtual_structure(faults: Any) -> None:
    def hash_of(controller: str, *changes: str) -> str:
        return sha(controller, "duration=1.5", STUCK, NOISE, *changes)

    assert hash_of("virtual_structure", faults) == hash_of("virtual_structure")
    assert hash_of("nash", faults) != hash_of("nash")


def test_a_robot_of_a_virtual_structure_does_not_care_what_becomes_of_the_others() -> None:
    def poses(*changes: str) -> FloatArray:
        simulation = Simulation(scenario("virtual_structure", "duration=3", *changes))
        simulation.simulate()
        return simulation.trace.poses

    stuck, free = poses(STUCK), poses()
    assert (stuck[:, [0, 2]] == free[:, [0, 2]]).all()
    assert np.abs(stuck[:, 1] - free[:, 1]).max() > 0.05


# ---------------------------------------------------------------- consensus


def hand(pose: FloatArray, reach: float) -> FloatArray:
    return pose[:2] + reach * np.array([math.cos(pose[2]), math.sin(pose[2])])


def law(pose: FloatArray, slot: FloatArray, v: FloatArray, error: FloatArray, gains: FloatArray) -> FloatArray:
    """First input of the law, for a neighbour whose hand has this error; all slots move with v."""
    out, targets = np.empty((2, 2)), np.tile(v, (2, 1))
    other = np.array([5.0, -3.0, 0.7])
    shifted = other + np.array([*error, 0.0])
    roll_law(pose, slot, targets, shifted, other, targets, targets, 0.05, gains, DT, LIMITS, out)
    return out[0]


@given(SEEDS, st.sampled_from([-1.0, 1.0]))
@settings(max_examples=50)
def test_errors_of_hands_obey_the_linear_consensus_law(seed: Any, ahead: Any) -> None:
    g = np.random.default_rng(seed)
    slot = np.array([*g.uniform(-1, 1, 2), g.uniform(-3, 3)])
    pose = slot + np.array([*g.uniform(-0.02, 0.02, 2), g.uniform(-0.3, 0.3)])
    v, other, gains = np.array([0.1 * ahead, g.uniform(-0.3, 0.3)]), g.uniform(-0.02, 0.02, 2), np.array([0.7, 0.4])
    reach = 0.05 * ahead
    u = law(pose, slot, v, other, gains)
    assert (np.abs(u) < LIMITS).all()

    def error(dt: float) -> FloatArray:
        moved, there = np.array(step(*pose, *u, dt)), np.array(step(*slot, *v, dt))
        return hand(moved, reach) - hand(there, reach)

    h = 1e-5
    rate = (error(h) - error(-h)) / (2 * h)
    np.testing.assert_allclose(rate, -gains[0] * error(0.0) - gains[1] * (error(0.0) - other), atol=1e-8)


@given(SEEDS)
@settings(max_examples=50)
def test_beyond_the_limits_the_hand_goes_the_same_way_more_slowly(seed: Any) -> None:
    g = np.random.default_rng(seed)
    slot, pose = (np.array([*g.uniform(-1, 1, 2), g.uniform(-3, 3)]) for _ in range(2))
    v, gains, none = np.array([0.1, 0.2]), np.array([1.0, 1.0]), np.zeros(2)
    u = law(pose, slot, v, none, gains)
    wide = np.empty((2, 2))
    targets = np.tile(v, (2, 1))
    roll_law(pose, slot, targets, slot, slot, targets, targets, 0.05, gains, DT, np.full(2, 1e9), wide)
    share = min(1.0, float((LIMITS / np.abs(wide[0])).min()))
    np.testing.assert_allclose(u, share * wide[0], rtol=1e-9)


def test_a_consensus_plan_is_the_law_followed_over_the_horizon() -> None:
    g = np.random.default_rng(1)
    poses = [np.array([*g.uniform(-0.1, 0.1, 2), g.uniform(-0.5, 0.5)]) for _ in range(4)]
    targets, others, theirs = (np.tile([0.1, w], (20, 1)) for w in (0.1, 0.3, -0.2))
    gains, out = np.array([1.0, 1.0]), np.empty((20, 2))
    roll_law(poses[0], poses[1], targets, poses[2], poses[3], others, theirs, 0.05, gains, DT, LIMITS, out)
    later = np.empty((19, 2))
    moved = [
        np.array(step(*pose, *u, DT)) for pose, u in zip(poses, (out[0], targets[0], others[0], theirs[0]), strict=True)
    ]
    roll_law(
        *moved[:2], targets[1:].copy(), *moved[2:], others[1:].copy(), theirs[1:].copy(), 0.05, gains, DT, LIMITS, later
    )
    np.testing.assert_allclose(later, out[1:], atol=1e-12)


def test_consensus_waits_for_a_stuck_neighbour_only_if_it_is_told() -> None:
    told = simulate(scenario("consensus", "duration=4", STUCK))
    cut = simulate(scenario("consensus", "duration=4", STUCK, "link.cut=true"))
    assert worst(told, "max") < 0.95 * worst(cut, "max")


@given(st.floats(0.05, 2.0), st.floats(0.02, 9.0), st.floats(0.2, 90.0), st.sampled_from([0.05, 0.1, 0.4]))
def test_gains_are_as_large_as_limits_and_sampling_allow(spacing: Any, v: Any, omega: Any, interval: Any) -> None:
    own = scenario(
        "consensus",
        f"formation.spacing={spacing}",
        f"robots.limits={{v={v}, omega={omega}}}",
        f"controller.prediction_interval={interval}",
    )
    law = Consensus(own, Task(own, 1))
    used = [
        law._gain * spacing / v,  # an error of one spacing asks for no more than the speed there is
        law._gain * spacing / (omega * law._reach),  # nor, across, for a faster turn
        2.0 * law._gain * interval / 0.25,  # both gains take away at most a quarter of an error per interval
    ]
    assert max(used) == pytest.approx(1.0)


def test_a_gain_that_is_given_is_used() -> None:
    own = scenario("consensus", "controller.gain=3")
    assert Consensus(own, Task(own, 1))._gain == 3.0


# ---------------------------------------------------------------- centralised


class Case:
    """n robots near a ring of slots, with inputs and weights drawn from a seed."""

    def __init__(self, seed: int, n: int, horizon: int, spread: float) -> None:
        g = np.random.default_rng(seed)
        around = 2 * np.pi * np.arange(n) / n
        places = 0.1 * np.stack([np.cos(around), np.sin(around)], axis=1)
        self.slots = np.zeros((horizon + 1, n, 3))
        self.slots[..., :2] = places + 0.01 * np.arange(horizon + 1)[:, None, None]
        self.slots[..., 2] = np.pi / 4
        self.targets = np.tile([0.1 * math.sqrt(2), 0.0], (horizon, n, 1))
        self.x0 = (self.slots[0] + spread * g.standard_normal((n, 3)) * [0.1, 0.1, 1.0]).ravel()
        self.weights = np.empty((horizon + 1, 3 * n, 3 * n))
        if n == 1:
            self.weights[:] = np.diag([1.0, 1.0, 0.01])
        else:
            ring_weights(self.slots, np.array(Q), self.weights)
        self.u = self.targets.reshape(horizon, 2 * n) + 0.1 * g.standard_normal((horizon, 2 * n))

    @property
    def task(self) -> tuple[Any, ...]:
        return self.slots, self.targets, self.weights, np.tile(R, self.slots.shape[1]), DT

    def cost(self, u: FloatArray) -> float:
        return cost(self.x0, u, *self.task)

    def optimum(self, limits: FloatArray, steps: int = 200) -> FloatArray:
        out = np.empty_like(self.u)
        change = optimise(self.x0, self.u, *self.task, limits, steps, 1e-10, out)
        assert change <= 1e-6
        return out

    def slope(self, u: FloatArray) -> FloatArray:
        """Gradient of the cost by finite differences."""
        h, out = 1e-5, np.empty_like(u)
        for at in np.ndindex(u.shape):
            there = np.zeros_like(u)
            there[at] = h
            out[at] = (self.cost(u + there) - self.cost(u - there)) / (2 * h)
        return out


@pytest.mark.parametrize("n", [1, 2, 3, 5])
@pytest.mark.parametrize("seed", range(3))
def test_at_the_optimum_the_gradient_vanishes(n: int, seed: int) -> None:
    case = Case(seed, n, 8, 0.3)
    wide = np.array([1e3, 1e3])
    assert np.abs(case.slope(case.u)).max() > 1e-3
    assert np.abs(case.slope(case.optimum(wide))).max() < 1e-8


@pytest.mark.parametrize("n", [2, 3])
@pytest.mark.parametrize("seed", range(4))
def test_within_limits_the_gradient_points_out_of_them_where_it_does_not_vanish(n: int, seed: int) -> None:
    case, limits = Case(seed, n, 8, 1.0), np.array([0.2, 0.5])
    u = case.optimum(limits)
    bound = np.tile(limits, n)
    slope, held = case.slope(u), np.abs(u) >= bound - 1e-12
    assert 0 < held.sum() < held.size
    assert (np.abs(u) <= bound).all()
    assert (np.abs(slope[~held]) < 1e-7).all()
    assert (slope[held] * np.sign(u[held]) < 1e-7).all()


@given(SEEDS)
@settings(max_examples=10, deadline=None)
def test_no_step_ever_raises_the_cost(seed: Any) -> None:
    case, limits = Case(seed, 3, 8, 2.0), np.array([0.3, 1.0])
    before = case.cost(np.clip(case.u, -np.tile(limits, 3), np.tile(limits, 3)))
    for steps in (1, 2, 4):
        out = np.empty_like(case.u)
        optimise(case.x0, case.u, *case.task, limits, steps, 0.0, out)
        assert case.cost(out) <= before + 1e-15
        before = case.cost(out)


@pytest.mark.parametrize("name", ["figure8", "triangle-circle", "square-figure8"])
def test_the_teams_cost_is_the_sum_of_the_games_that_nash_plays(name: str) -> None:
    task, k, g = load(name), 700, np.random.default_rng(5)
    slots, targets, weights, r, interval = Team(task).problem(k)
    n = task.size
    x = slots[0] + 0.02 * g.standard_normal((n, 3))
    u = targets + 0.05 * g.standard_normal(targets.shape)
    games = 0.0
    for i in range(1, n + 1):
        pair, both = Task(task, i), [i - 1, upstream(i, n) - 1]
        ahead, (q, own_r) = pair.ahead(k), nash_weights(task)
        poses, inputs = x[both].ravel(), np.ascontiguousarray(u[:, both].reshape(len(u), 4))
        games += pair_cost(poses, inputs, ahead.slots, ahead.inputs, interval, np.array(q), np.array([*own_r, *own_r]))
    # The pair's share of R is half of what its robot's inputs cost in both of its games.
    effort = 0.5 * float(((u - targets).reshape(len(u), -1) ** 2 @ r).sum())
    both_games = cost(x.ravel(), u.reshape(len(u), -1), slots, targets, weights, r, interval) + effort
    assert both_games == pytest.approx(games, rel=1e-9)


def test_agents_that_play_nash_never_plan_cheaper_than_the_team() -> None:
    simulation = Simulation(scenario("nash", "duration=3", NOISE, DISORDER, "controller.waits=false"))
    team = Team(simulation.world.scenario)
    dearer = []
    while not simulation.finished:
        k, poses = simulation.world.k, simulation.world.plant.poses
        simulation.step()
        if k % 20:
            continue
        team.see(k, poses, NOTHING_YET, NOTHING_YET)
        best, converged = team.plan(k)
        assert converged
        played = np.stack([_plan_of(simulation.agents[i]) for i in simulation.world.robots], axis=1)
        slots, targets, weights, r, interval = team.problem(k)

        def cost_of(u: FloatArray, x: FloatArray = poses, task: Any = (slots, targets, weights, r, interval)) -> float:
            return cost(x.ravel().copy(), np.ascontiguousarray(u.reshape(len(u), -1)), *task)

        dearer.append(cost_of(played) - cost_of(best))
    assert min(dearer) >= 0.0
    assert max(dearer) > 1e-5


def _plan_of(agent: Agent) -> FloatArray:
    assert agent._last is not None
    return agent._last[1].inputs


def test_the_team_sees_through_noise_and_needs_no_message() -> None:
    blur = "noise={position=0.005, heading=0.05}"
    here = sha("centralised", "duration=2", STUCK)
    assert sha("centralised", "duration=2", STUCK, blur, "link={latency=0.3, loss=0.5}") == here
    assert sha("nash", "duration=2", STUCK, blur) != sha("nash", "duration=2", STUCK)


def test_the_team_waits_for_a_stuck_robot_and_only_then() -> None:
    def lags(*changes: str) -> tuple[float, float]:
        """Largest before the robot is stuck, and at its release [s]."""
        simulation, before = Simulation(scenario("centralised", "duration=2.5", *changes, name="circle")), 0.0
        assert simulation._team is not None
        while not simulation.finished:
            simulation.step()
            if simulation.world.now <= 0.5:
                before = max(before, simulation._team.lag)
        return before, simulation._team.lag

    assert lags(STUCK)[0] == 0.0
    assert lags(STUCK)[1] > 1.0
    assert lags() == (0.0, 0.0)
    assert lags(STUCK, "controller.waits=false") == (0.0, 0.0)


def test_the_team_must_be_shown_the_poses_of_the_tick() -> None:
    task = scenario("centralised")
    team = Team(task)
    team.see(0, task.start_poses(), NOTHING_YET, NOTHING_YET)
    assert team.plan(0)[1]
    with pytest.raises(RuntimeError, match="tick 1"):
        team.plan(1)


LATE = "bodies={delay=0.05, lag=0.08, acceleration=2, turn_acceleration=20}"


def test_the_team_plans_from_where_robots_will_be_once_commands_act() -> None:
    """Where bodies are as they are said to be, it knows that to the last digits, from the first tick on."""
    simulation = Simulation(scenario("centralised", "duration=1.5", LATE, DISORDER))
    team, true, foreseen = cast(Team, simulation._team), [], []
    while not simulation.finished:
        true.append(simulation.world.plant.poses)
        simulation.step()
        assert team._now is not None
        assert team._now[0] == simulation.world.k - 1 + 5
        foreseen.append(team._now[1])
    np.testing.assert_allclose(foreseen[:-5], true[5:], atol=1e-12)
    assert np.abs(np.array(true[5:]) - true[:-5]).max() > 1e-3


@pytest.mark.parametrize("bodies", ["turtlebot3", "epuck", "camera", "{delay=0.2}"])
def test_the_team_keeps_late_robots_in_formation(bodies: str) -> None:
    summary = simulate(scenario("centralised", "duration=6", f"bodies={bodies}"), warmup=4.0)
    assert worst(summary, "max") < 20.0


def test_a_team_that_is_nowhere_says_so_and_keeps_its_limits() -> None:
    task = scenario("centralised", "controller.waits=false")
    team = Team(task)
    team.see(0, np.full((3, 3), np.nan), NOTHING_YET, NOTHING_YET)
    inputs, converged = team.plan(0)
    assert not converged
    assert (np.abs(inputs) <= LIMITS).all()


# ---------------------------------------------------------------- where it cannot simulate


def refused(mistake: Any) -> None:
    text = str(mistake.value)
    assert "\n" not in text
    for word in ("centralised", "--engine inprocess", *live()):
        assert word in text


def test_every_controller_can_run_live_or_is_refused_by_name() -> None:
    assert set(live()) | set(IN_PROCESS) == set(names())
    for name in names():
        task = scenario(name)
        if name in live():
            assert Agent(task, 2).step(builders.tick(0, task.start_poses())).plan is not None
        else:
            with pytest.raises(ScenarioError) as mistake:
                Agent(task, 2)
            refused(mistake)


def test_processes_and_containers_refuse_what_only_one_process_can_do() -> None:
    with pytest.raises(ScenarioError) as mistake:
        LiveRun("none", scenario("centralised"), tell=print)
    refused(mistake)
    with pytest.raises(ScenarioError) as mistake:
        compose_file("circle", scenario("centralised"))
    refused(mistake)


def test_a_live_world_refuses_it_and_goes_on_as_before() -> None:
    world = World(load("circle"))
    orders = RunControl(world, cast(Any, None), cast(Any, None), go=True)
    wishes = (
        UseController(controller="centralised"),
        UseScenario(scenario="figure8", overrides={"controller": {"name": "centralised"}}),
    )
    for wish in wishes:
        with pytest.raises(ScenarioError) as mistake:
            orders.obey(wish)
        refused(mistake)
    assert (world.scenario.name, world.scenario.controller.name, world.episode) == ("circle", "nash", 0)


def test_the_page_does_not_offer_it() -> None:
    gui = MagicMock()
    RunPanel(gui, MagicMock(), ScenarioList(), MagicMock())
    offered = {call.args[0]: call.args[1] for call in gui.add_dropdown.call_args_list}
    assert set(offered["Controller"]) == set(names()) - {"centralised"}
