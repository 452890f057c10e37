"""Laws of what robots believe, as the page has it."""

import numpy as np
import pytest

from dashboard.telemetry.beliefs import beliefs
from formation.unicycle import step
from tests.builders import motion, state, status

INPUTS = np.column_stack([np.linspace(0.1, 0.3, 20), np.linspace(-1.0, 1.0, 20)])


def at(seconds: float) -> tuple[float, float, float]:
    """Where the inputs lead from the origin, in small steps; the last one holds on, and the first held before."""
    x, y, theta = 0.0, 0.0, 0.0
    for i in range(round(abs(seconds) / 1e-3)):
        row = min(int((i + 0.5) * 1e-3 / 0.1), 19) if seconds > 0.0 else 0
        v, omega = INPUTS[row].tolist()
        x, y, theta = step(x, y, theta, v, omega, np.sign(seconds) * 1e-3)
    return x, y, theta


@pytest.mark.parametrize("elapsed", [-0.05, 0.0, 0.03, 0.55, 2.5])
def test_a_belief_is_carried_to_the_moment_and_its_error_is_the_distance_to_the_truth(elapsed: float) -> None:
    poses = np.array([[1.0, 0.0, 0.0], [0.5, 0.5, 0.0], [0.0, 0.0, 0.0]])
    held = motion(begins=3.0, pose=np.zeros(3), inputs=INPUTS)
    now = state(poses=poses)
    (found,) = beliefs(now, {2: status(2, 1, believes=held)}, poses, 3.0 + elapsed, 0.1)
    assert (found.receiver, found.sender) == (2, 1)
    np.testing.assert_allclose(found.pose, at(elapsed), atol=1e-9)
    assert found.error == pytest.approx(np.hypot(*(poses[0, :2] - found.pose[:2])))
    np.testing.assert_allclose(found.line[0], found.pose[:2])


def test_of_another_episode_nothing_is_believed() -> None:
    held = motion(begins=0.0, pose=np.zeros(3), inputs=INPUTS)
    assert beliefs(state(episode=1), {2: status(2, 1, believes=held)}, np.zeros((3, 3)), 0.0, 0.1) == []
