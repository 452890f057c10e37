"""Laws of the ghost's track: it is drawn where it was at the stamp of the robots, and starts anew with its episode."""

from dataclasses import replace

import numpy as np
import pytest

from dashboard.telemetry.ghost_track import FAR_BEHIND, GhostTrack
from formation.arrays import FloatArray
from network.messages import State
from tests.dashboard.fakes import beside, ghost


def places(track: GhostTrack, stamp: float) -> FloatArray:
    poses = track.poses(stamp)
    assert poses is not None
    return poses


@pytest.mark.parametrize("stamp", [1.0, 1.03, 2.999, 3.0])
def test_the_ghost_is_drawn_where_it_was_at_the_stamp_of_the_robots(stamp: float) -> None:
    track = GhostTrack()
    track.update(beside(3.0), [ghost(0.1 * i) for i in range(40)])
    np.testing.assert_allclose(places(track, stamp)[:, 0], stamp, atol=1e-12)


def test_between_two_messages_the_ghost_turns_the_short_way_round() -> None:
    track = GhostTrack()
    track.update(beside(3.2), [ghost(3.1), ghost(3.2)])
    assert np.abs(np.abs(places(track, 3.15)[:, 2]) - np.pi).max() < 0.02


def test_a_ghost_that_is_far_behind_is_not_drawn() -> None:
    track = GhostTrack()
    track.update(beside(5.0), [ghost(1.0), ghost(1.1)])
    assert track.poses(5.0) is None
    assert track.poses(1.1 + 0.9 * FAR_BEHIND) is not None


@pytest.mark.parametrize(
    "now", [beside(4.0, episode=1), replace(beside(4.0), compare=""), replace(beside(4.0), compare="nash")]
)
def test_a_ghost_of_another_episode_or_controller_is_dropped(now: State) -> None:
    track = GhostTrack()
    track.update(beside(3.0), [ghost(2.9), ghost(3.0)])
    assert track.newest is not None
    track.update(now, [ghost(3.1)])
    assert track.newest is None
    assert track.poses(3.0) is None
    assert np.isnan(track.at(np.array([3.0]))["ghost_distance"]).all()


def test_a_ghost_that_restarts_drops_its_former_poses() -> None:
    track = GhostTrack()
    track.update(beside(3.0), [ghost(0.1 * i) for i in range(30)])
    track.update(beside(3.0), [ghost(0.1), ghost(0.2)])
    assert track.newest is not None
    assert track.newest.stamp == 0.2
    known = np.isfinite(track.at(np.array([0.0, 0.1, 0.15, 0.2, 2.0]))["ghost_angle"])
    assert known.tolist() == [False, True, True, True, False]
