"""Laws of the scene's layers."""

import numpy as np
import pytest

from dashboard.scene.layers import Sizes, arrows, held_plans, horizons, own_plans
from dashboard.telemetry.links import ring_links
from formation.faults import Fault
from formation.link_ids import LinkId
from tests.builders import plan, state, status


def test_the_belief_that_is_drawn_is_the_plan_that_the_neighbour_holds() -> None:
    message = {
        1: status(1, 3, plan=plan(1, 99), held=plan(3, 49)),
        2: status(2, 1, plan=plan(2, 99), held=plan(1, 7)),
        3: status(3, 2, plan=plan(3, 99, episode=1), held=plan(1, 8)),  # of another episode; of another robot
    }
    numbers = [
        [None if p is None else (p.sender, p.seq) for p in plans(message, 3, 0)] for plans in (own_plans, held_plans)
    ]
    assert numbers == [[(1, 99), (2, 99), None], [(1, 7), None, (3, 49)]]


@pytest.mark.parametrize("robots", [2, 3, 20])
def test_an_arrow_runs_on_the_right_of_the_way_from_sender_to_receiver_and_is_dashed_when_lost(robots: int) -> None:
    poses = np.random.default_rng(robots).uniform(-0.5, 0.5, (robots, 3))
    now = state(robots, faults={LinkId(1, 2): Fault(cut=True)})
    drawn = arrows(poses, ring_links(now, {}), Sizes.of(0.1), 7)
    shafts = drawn.shafts.reshape(robots, -1, 2, 3)[..., :2]
    for sender in range(robots):
        start, way = poses[sender, :2], np.roll(poses, -1, axis=0)[sender, :2] - poses[sender, :2]
        along, right = way / np.hypot(*way), np.array([way[1], -way[0]]) / np.hypot(*way)
        points = np.concatenate([shafts[sender].reshape(-1, 2), drawn.tips[sender : sender + 1, :2]])
        np.testing.assert_allclose((points - start) @ right, 0.011)
        places = (points - start) @ along
        assert (np.diff(places) > -1e-12).all()
        assert 0.0 < places[0] < places[-1] < np.hypot(*way)
        assert drawn.directions[sender] == pytest.approx(np.arctan2(way[1], way[0]))
        gaps = shafts[sender, 1:, 0] - shafts[sender, :-1, 1]
        assert (np.abs(gaps) > 1e-6).any() == (sender == 0), "dashed if cut, else in one piece"


@pytest.mark.parametrize("elapsed", [0.0, 0.25, 1.0, 5.0])
def test_of_an_older_plan_the_rest_is_drawn_from_where_the_robot_is(elapsed: float) -> None:
    poses, message = np.array([[3.0, 4.0, 0.5]]), plan(1, 100)
    ahead = horizons([message], poses, 20, message.stamp + elapsed)[0]
    left = max(0, 20 - int(elapsed / 0.1))
    np.testing.assert_allclose(ahead[0], [3.0, 4.0])
    np.testing.assert_allclose(np.hypot(*np.diff(ahead, axis=0).T) > 1e-9, np.arange(20) < left)
    np.testing.assert_allclose(horizons([message], poses, 20)[0, 0], message.pose[:2])
