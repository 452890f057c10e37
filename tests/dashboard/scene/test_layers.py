"""Laws of the scene's layers."""

import numpy as np
import pytest

from dashboard.scene.layers import Sizes, arrows, believed, edges, horizons, off, own_plans
from dashboard.telemetry.beliefs import BeliefView
from dashboard.telemetry.links import ring_links
from formation.faults import Fault
from formation.link_ids import LinkId
from tests.builders import motion, state, status


def test_of_plans_those_of_the_episode_are_drawn() -> None:
    drawn = motion()
    message = {1: status(1, 3, plan=drawn), 3: status(3, 2, plan=motion(), episode=1)}
    assert own_plans(message, 3, 0) == [drawn, None, None]


def test_a_belief_is_drawn_at_the_robot_that_it_is_about_and_dashes_lead_there_if_it_is_far_off() -> None:
    poses = np.array([[0.0, 0.0, 0.0], [0.1, 0.0, 0.0], [0.2, 0.0, 0.0]])
    line = np.linspace([0.5, 0.5], [0.6, 0.5], 21)
    far = BeliefView(receiver=2, sender=1, pose=np.array([0.5, 0.5, 1.0]), line=line, offset=np.array([0.5, 0.5]))
    near = BeliefView(receiver=3, sender=2, pose=np.array([0.101, 0.0, 0.0]), line=line, offset=np.array([0.001, 0.0]))
    places, lines = believed([far, near], poses, 20)
    np.testing.assert_array_equal(places, [far.pose, near.pose, poses[2]])
    np.testing.assert_array_equal(lines[0], line)
    dashes = off([far, near], poses, 8).reshape(3, -1, 2, 2)
    np.testing.assert_allclose(dashes[0, 0, 0], poses[0, :2])
    assert np.hypot(*(dashes[0] - far.pose[:2]).T).min() < 0.1
    assert np.ptp(dashes[1:], axis=(1, 2)).max() == 0.0, "nothing to be seen"


@pytest.mark.parametrize("robots", [2, 3, 20])
def test_an_arrow_runs_on_the_right_of_the_way_from_sender_to_receiver_and_is_dashed_when_lost(robots: int) -> None:
    poses = np.random.default_rng(robots).uniform(-0.5, 0.5, (robots, 3))
    now = state(robots, faults={LinkId(1, 2): Fault(cut=True)})
    drawn = arrows(poses, ring_links(now, {}), Sizes(1.0), 7)
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


def test_the_ring_is_drawn_closed_over_a_robot_that_is_away() -> None:
    poses = np.random.default_rng(1).uniform(-0.5, 0.5, (4, 3))
    now = state(4, away=[2], live=[1, 3, 4])
    lines = edges(poses, 0.0, now.away)[..., :2]
    np.testing.assert_array_equal(lines[2], poses[[2, 0], :2])
    assert np.ptp(lines[1], axis=0).max() == 0.0, "nothing to be seen"
    drawn = arrows(poses, ring_links(now, {}), Sizes(1.0), 7)
    way = poses[2, :2] - poses[0, :2]
    assert drawn.directions[0] == pytest.approx(np.arctan2(way[1], way[0]))
    assert np.abs(drawn.tips[1, :2]).min() > 1e3, "out of sight"


@pytest.mark.parametrize("elapsed", [0.0, 0.25, 1.0, 5.0])
def test_of_an_older_plan_the_rest_is_drawn_from_where_the_robot_is(elapsed: float) -> None:
    poses, drawn = np.array([[3.0, 4.0, 0.5]]), motion()
    ahead = horizons([drawn], poses, 20, drawn.begins + elapsed)[0]
    left = max(0, 20 - int(elapsed / 0.1))
    np.testing.assert_allclose(ahead[0], [3.0, 4.0])
    np.testing.assert_allclose(np.hypot(*np.diff(ahead, axis=0).T) > 1e-9, np.arange(20) < left)
