"""Laws of the ghost on the page: it stands where it was at the very stamp that is drawn, and the verdict is plain."""

from dataclasses import replace
from html import escape
from typing import Any

import numpy as np
import pytest

from dashboard.panels import plots
from dashboard.panels.comparison import comparison
from dashboard.telemetry.ghost_track import FAR_BEHIND, Comparison, GhostTrack, comparisons
from dashboard.telemetry.history import History
from formation.arrays import FloatArray
from network.messages import Ghost, State
from tests.builders import state


def ghost(stamp: float, *, episode: int = 0, controller: str = "paper", error: float = 0.01) -> Ghost:
    """Robots that drive along x at 1 m/s and turn over the cut of the angle."""
    poses = np.stack([[stamp, float(i), (stamp + np.pi) % (2.0 * np.pi) - np.pi] for i in range(3)])
    return Ghost(0, 1, stamp, episode, controller, poses, np.full(3, error), np.zeros(3), error)


def beside(stamp: float, **changes: object) -> State:
    return state(stamp=stamp, compare="paper", **changes)  # type: ignore[arg-type]


def places(track: GhostTrack, stamp: float) -> FloatArray:
    poses = track.poses(stamp)
    assert poses is not None
    return poses


@pytest.mark.parametrize("stamp", [1.0, 1.03, 2.999, 3.0])
def test_the_ghost_is_drawn_where_it_was_at_the_stamp_of_the_robots(stamp: float) -> None:
    track = GhostTrack()
    track.update(beside(3.0), [ghost(0.1 * i) for i in range(40)])
    np.testing.assert_allclose(places(track, stamp)[:, 0], stamp, atol=1e-12)


def test_between_two_words_the_ghost_turns_the_short_way_round() -> None:
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
def test_a_ghost_of_another_flight_or_comparison_is_forgotten(now: State) -> None:
    track = GhostTrack()
    track.update(beside(3.0), [ghost(2.9), ghost(3.0)])
    assert track.newest is not None
    track.update(now, [ghost(3.1)])
    assert track.newest is None
    assert track.poses(3.0) is None
    assert np.isnan(track.at(np.array([3.0]))["ghost_distance"]).all()


def test_a_ghost_that_begins_again_leaves_nothing_of_its_former_self() -> None:
    track = GhostTrack()
    track.update(beside(3.0), [ghost(0.1 * i) for i in range(30)])
    track.update(beside(3.0), [ghost(0.1), ghost(0.2)])
    assert track.newest is not None
    assert track.newest.stamp == 0.2
    known = np.isfinite(track.at(np.array([0.0, 0.1, 0.15, 0.2, 2.0]))["ghost_angle"])
    assert known.tolist() == [False, True, True, True, False]


def flown(live: float, other: float, seconds: float = 30.0) -> History:
    """Both flights, with constant errors [m]."""
    history = History()
    for i in range(int(20 * seconds)):
        now = beside(0.05 * i, distance_errors=np.full(3, live), tracking_error=live)
        history.ghost.update(now, [ghost(0.05 * i, error=other)])
        history.add(now, [])
    return history


@pytest.mark.parametrize(
    ("live", "other", "words"),
    [
        (0.001, 0.012, "12 x better"),
        (0.012, 0.001, "12 x worse"),
        (0.001, 0.00104, "the same"),
        (0.001, 0.0025, "2.5 x better"),
        (1e-9, 1e-8, "the same"),
        (1e-9, 0.0472, "> 1000 x better"),
    ],
)
def test_the_verdict_says_how_many_times_better_or_worse(live: float, other: float, words: str) -> None:
    history = flown(live, other)
    found = comparisons(history.series())
    assert [verdict.factor for verdict in found] == [words, words]
    html = comparison(beside(30.0), history)
    assert html.count(escape(words)) == 2
    assert "nash" in html
    assert "paper" in html


def test_only_what_both_have_flown_is_compared() -> None:
    history = flown(0.001, 0.01, seconds=5.0)
    for i in range(100, 200):  # the ghost falls silent, and the live flight goes wild
        history.add(beside(0.05 * i, distance_errors=np.full(3, 9.0)), [])
    assert comparisons(history.series())[0].factor == "10 x better"


def test_without_a_ghost_there_is_no_verdict_but_a_word_of_why() -> None:
    history = History()
    for i in range(100):
        history.add(beside(0.1 * i), [])
    assert comparisons(history.series()) == []
    assert "Waiting for the ghost" in comparison(beside(9.9), history)
    history.ghost.update(beside(9.9), [ghost(3.0)])
    assert "3 of 10 s" in comparison(beside(9.9), history)
    assert comparison(state(stamp=9.9), history) == ""


def test_names_from_elsewhere_are_escaped() -> None:
    hostile: Any = "<img src=x onerror=alert(1)>"
    history = flown(0.001, 0.01)
    assert "<img" not in comparison(replace(beside(30.0), controller=hostile), history)


def test_errors_that_are_nothing_on_the_ground_are_no_victory() -> None:
    assert Comparison("distance", 1e-5, 1e-4).factor == "the same"


def test_the_ghosts_line_goes_on_while_its_word_is_under_way_and_no_longer() -> None:
    stamps = np.arange(0.0, 6.0, 0.1)
    values = np.where((stamps > 2.0) & (stamps < 4.0), 7.0, np.nan)
    drawn = plots._held(stamps, values)
    known = stamps[np.isfinite(drawn)]
    assert set(drawn[np.isfinite(drawn)]) == {7.0}
    assert known[0] == pytest.approx(2.1 - FAR_BEHIND, abs=0.11)
    assert known[-1] == pytest.approx(3.9 + FAR_BEHIND, abs=0.11)
    assert np.isnan(plots._held(stamps, np.full_like(stamps, np.nan))).all()
