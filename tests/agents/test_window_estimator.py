"""Laws of the estimator (docs/theory.md, section 12)."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from agents.controllers.task import Task
from agents.estimator import Estimate, Measurement
from agents.motor_model import MotorModel
from agents.window_estimator import WindowEstimator
from formation.arrays import FloatArray
from formation.scenario.files import load
from formation.scenario.scenario import Scenario
from runtime.inprocess import Simulation
from world.bodies.wheeled import WheeledBodies

TICKS = 80
SEEDS = st.integers(0, 2**32)


def estimator(scenario: Scenario, robot: int = 1) -> WindowEstimator:
    """Of a robot that hears nobody, and sees its upstream neighbour if the bodies do."""
    task = Task(scenario, robot)
    return WindowEstimator(scenario, task, MotorModel(scenario, task.limits), sees=True, listens=False)


def sensed(scenario: Scenario) -> tuple[list[FloatArray], dict[int, Measurement]]:
    """Odometry of robot 1 by tick, from the start on, and its measurements by the tick of their arrival."""
    bodies = WheeledBodies(scenario)
    speeds, found = [bodies.odometry[0]], {}
    inputs = scenario.reference().block(0).inputs[0]
    for k in range(TICKS):
        seen = bodies.measure()
        if seen is not None:
            relative = seen.relatives[0] if len(seen.relatives) else None
            found[k] = Measurement(seen.tick, seen.poses[0], relative)
        bodies.move(inputs)
        speeds.append(bodies.odometry[0])
    return speeds, found


def same(one: Estimate | None, other: Estimate | None) -> bool:
    assert one is not None
    assert other is not None
    arrays = ("pose", "speed", "twist", "disturbance", "covariance")
    return all(np.array_equal(getattr(one, name), getattr(other, name)) for name in arrays)


@pytest.mark.parametrize("bodies", ["ideal", {"lag": 0.1, "acceleration": 1.0}])
def test_on_bodies_without_noise_the_estimate_is_the_pose_to_the_last_bit(bodies: object) -> None:
    simulation = Simulation(load("triangle-circle", {"bodies": bodies}))
    for k in range(60):
        poses = simulation.world.plant.poses
        simulation.step()
        for robot, agent in simulation.agents.items():
            plan = agent.status(k, k * 0.01).plan
            assert plan is not None
            assert np.array_equal(plan.pose, poses[robot - 1])


@pytest.mark.parametrize("preset", ["mocap", "camera"])
@given(seed=SEEDS, order=st.randoms(use_true_random=False))
@settings(max_examples=8)
def test_in_whatever_order_measurements_arrive_the_estimate_is_the_same(preset: str, seed: int, order: object) -> None:
    scenario = load("triangle-circle", {"bodies": preset, "seed": seed, "robots": {}})
    speeds, found = sensed(scenario)
    prompt, late = estimator(scenario), estimator(scenario)
    for one in (prompt, late):
        one.begin(speeds[0])
    for k in range(TICKS):
        for one in (prompt, late):
            if k > 0:
                one.roll(k, speeds[k])
        if k in found:
            prompt.sense(found[k])
        prompt.estimate(k, None)
    shuffled = list(found.values())
    order.shuffle(shuffled)  # type: ignore[attr-defined]
    for measurement in shuffled:
        late.sense(measurement)
    assert same(prompt.estimate(TICKS - 1, None), late.estimate(TICKS - 1, None))


@given(seed=SEEDS, preset=st.sampled_from(["mocap", "camera", "rough"]))
@settings(max_examples=15)
def test_the_covariance_stays_symmetric_and_positive(seed: int, preset: str) -> None:
    scenario = load("triangle-circle", {"bodies": preset, "seed": seed, "robots": {}})
    speeds, found = sensed(scenario)
    of = estimator(scenario)
    of.begin(speeds[0])
    for k in range(TICKS):
        if k > 0:
            of.roll(k, speeds[k])
        if k in found:
            of.sense(found[k])
        of.estimate(k, None)
        covariance = of.window.copy_cov
        deviation = np.sqrt(np.diag(covariance))
        unit = covariance / np.outer(deviation, deviation)
        np.testing.assert_allclose(unit, unit.T, atol=1e-9)
        assert np.linalg.eigvalsh(0.5 * (unit + unit.T)).min() > 1e-9


def test_a_measurement_that_is_far_off_is_rejected_until_many_agree() -> None:
    scenario = load("triangle-circle", {"bodies": "mocap", "robots": {}})
    of, inputs = estimator(scenario), scenario.reference().block(0).inputs[0, 0]
    of.begin(inputs)
    start = scenario.start_poses()[0]
    rejected = []
    for k in range(1, 14):
        of.roll(k, inputs)
        of.sense(Measurement(k, start + np.array([1.0, 0.0, 0.0]), None))
        estimate = of.estimate(k, None)
        assert estimate is not None
        rejected.append(estimate.rejected)
    assert rejected[:8] == list(range(1, 9))
    assert rejected[8] == 0
