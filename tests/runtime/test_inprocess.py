"""The fast engine: it repeats itself, numbering does not matter, faults ignore the controller, figures are met."""

# mypy: disable-error-code="no-any-return"
# (unpacked poses, numpy scalars and shapes; what strict typing of numpy makes of test arithmetic)

from typing import Any

import numpy as np
import pytest

from agents.agent import Agent
from formation.arrays import FloatArray
from formation.link_ids import plan_links
from formation.pattern import downstream
from formation.scenario.files import load, parse
from formation.scenario.scenario import Scenario
from runtime.inprocess import simulate
from world.world import World

NOISY = ["noise.slip=0.2", "noise.gyro=0.2", "noise.position=0.001", "noise.heading=0.01"]


def millimetres(summary: dict[str, Any]) -> float:
    """RMS of l_e of the worst robot [mm]."""
    return 1e3 * max(robot["distance_error_m"]["rms"] for robot in summary["robots"].values())


def trajectory(scenario: Scenario) -> FloatArray:
    """True poses (ticks + 1, n, 3), with the engine's own loop."""
    world = World(scenario)
    agents = {i: Agent(scenario, i) for i in world.robots}
    poses = [world.plant.poses]
    while not world.finished:
        tick = world.tick()
        for agent in agents.values():
            agent.set_faults(world.faults.table)
        answers = {i: agent.step(tick) for i, agent in agents.items()}
        for i, answer in answers.items():
            if answer.plan is not None:
                agents[downstream(i, len(agents))].receive(answer.plan)
        world.advance({i: answer.command for i, answer in answers.items()})
        poses.append(world.plant.poses)
    return np.array(poses)


def ring(offsets: FloatArray, poses: FloatArray, controller: str) -> Scenario:
    return parse(
        {
            "name": "ring",
            "duration": 4.0,
            "path": {"kind": "circle"},
            "formation": {"offsets": offsets.tolist()},
            "robots": {"poses": poses.tolist()},
            "controller": {"name": controller},
        }
    )


@pytest.mark.parametrize("controller", ["nash", "paper"])
@pytest.mark.parametrize("turn", [1, 2])
def test_relabelling_the_robots_permutes_the_trajectories(controller: Any, turn: Any) -> None:
    base = load("triangle-circle")
    # A scalene triangle: no symmetry that would make the law trivial.
    offsets = np.array([[0.08, 0.0], [-0.05, 0.06], [-0.03, -0.06]])
    poses = np.array(base.robots.poses)
    here = trajectory(ring(offsets, poses, controller))
    there = trajectory(ring(np.roll(offsets, turn, axis=0), np.roll(poses, turn, axis=0), controller))
    np.testing.assert_allclose(there, np.roll(here, turn, axis=1), atol=1e-12)
    assert np.abs(here[-1] - here[0]).max() > 0.05  # they did simulate
    assert np.abs(there - here).max() > 0.01


def test_this_files_loop_is_that_of_the_engine() -> None:
    import hashlib

    scenario = load("figure8", ["duration=2", "link.loss=0.3", *NOISY])
    sha = hashlib.sha256(trajectory(scenario).tobytes()).hexdigest()
    assert simulate(scenario)["trajectory_sha256"] == sha


@pytest.mark.parametrize("settings", [[], NOISY, ["link.jitter=0.05", "link.latency=0.05", "link.loss=0.2"]])
def test_the_same_seed_gives_the_same_trajectory_to_the_last_bit(settings: Any) -> None:
    scenario = load("triangle-circle", ["duration=2", *settings])
    assert simulate(scenario)["trajectory_sha256"] == simulate(scenario)["trajectory_sha256"]


@pytest.mark.parametrize(
    "setting", ["noise.slip=0.2", "noise.gyro=0.2", "noise.position=0.001", "noise.heading=0.01", "link.loss=0.5"]
)
def test_another_seed_gives_another_trajectory_where_chance_has_a_part(setting: Any) -> None:
    def sha(seed: int) -> str:
        return str(simulate(load("triangle-circle", ["duration=1", f"seed={seed}", setting]))["trajectory_sha256"])

    assert sha(1) != sha(2)


def test_without_chance_the_seed_does_not_matter() -> None:
    shas = {simulate(load("triangle-circle", ["duration=1", f"seed={seed}"]))["trajectory_sha256"] for seed in (1, 2)}
    assert len(shas) == 1


def test_faults_do_not_depend_on_the_controller() -> None:
    faulty = [
        "duration=8",
        "link.latency=0.03",
        "link.jitter=0.02",
        "link.loss=0.3",
        "link.burst=12",
        "link.duplicate=0.1",
        "link.corrupt=0.05",
    ]
    counts = []
    for controller in ("nash", "leader_follower", "paper"):
        summary = simulate(load("triangle-circle", [*faulty, f"controller.name={controller}"]))
        counts.append({link: {k: v for k, v in c.items() if k != "age_s"} for link, c in summary["links"].items()})
        for c in summary["links"].values():
            assert c["sent"] + c["duplicated"] == c["delivered"] + c["lost"] + c["in_flight"]
            assert min(c["lost"], c["late"], c["corrupt"], c["duplicated"]) > 0
    assert counts[0] == counts[1] == counts[2]
    assert set(counts[0]) == set(map(str, plan_links(3)))


def test_every_link_counts_the_same_number_of_plans() -> None:
    summary = simulate(load("triangle-circle", ["duration=1"]))
    sent = {link: c["sent"] for link, c in summary["links"].items()}
    assert len(set(sent.values())) == 1, sent


def test_a_link_with_only_latency_shows_it_as_the_age_of_its_plans() -> None:
    summary = simulate(load("triangle-circle", ["duration=3", "link.latency=0.25"]), warmup=1.0)
    for link in summary["links"].values():
        assert link["age_s"]["median"] == pytest.approx(0.25)
        assert link["age_s"]["max"] == pytest.approx(0.25)


def test_progress_is_told_in_growing_simulated_time() -> None:
    told: list[float] = []
    simulate(load("circle", ["duration=2"]), progress=told.append)
    assert told == sorted(told)
    assert len(told) == 4


# ---------------------------------------------------------------- figures of the README, on short episodes


def test_nash_keeps_a_triangle_on_a_circle_to_a_twentieth_of_a_millimetre() -> None:
    summary = simulate(load("triangle-circle", ["duration=20"]), warmup=15.0)
    assert millimetres(summary) <= 0.05
    assert summary["tracking_error_m"]["rms"] <= 2e-3


def test_nash_does_so_with_every_plan_half_a_second_late() -> None:
    summary = simulate(load("triangle-circle", ["duration=20", "link.latency=0.5"]), warmup=15.0)
    assert millimetres(summary) <= 0.05
    for link in summary["links"].values():
        assert link["age_s"]["median"] == pytest.approx(0.5)


@pytest.mark.parametrize(("name", "worst"), [("circle", 0.05), ("sinusoid", 0.05), ("figure8", 0.3)])
def test_nash_keeps_two_robots_in_line(name: Any, worst: Any) -> None:
    summary = simulate(load(name, ["duration=14"]), warmup=10.0)
    assert millimetres(summary) <= worst
    assert summary["tracking_error_m"]["rms"] <= 2e-3


def test_nash_keeps_the_spiral_from_the_first_tick_on() -> None:
    assert (
        millimetres(simulate(load("spiral", ["duration=15"]))) <= 2.0
    )  # 0.6 over the whole run; its start is the worst


def test_old_plans_taken_as_if_fresh_are_worse_than_aged_ones() -> None:
    late = ["duration=10", "link.latency=0.5"]
    aged = simulate(load("triangle-circle", late), warmup=8.0)
    fresh = simulate(load("triangle-circle", [*late, "controller.age_plans=false"]), warmup=8.0)
    assert fresh["tracking_error_m"]["rms"] > 3 * aged["tracking_error_m"]["rms"]


def test_the_baselines_are_worse_than_nash_by_far() -> None:
    def worst(controller: str) -> float:
        return millimetres(simulate(load("circle", ["duration=9", f"controller.name={controller}"]), warmup=5.0))

    nash, paper, follower = worst("nash"), worst("paper"), worst("leader_follower")
    assert nash < 0.05
    assert nash < paper / 20 < follower / 20
