"""Laws of the tape: a moment is shown again as it was, memory is bounded, and a reset begins another episode on it."""

from typing import Any

import numpy as np
import pytest

from dashboard.telemetry.beliefs import BeliefView
from dashboard.telemetry.origin import HERE
from dashboard.telemetry.playhead import Playhead
from dashboard.telemetry.snapshot import Snapshot
from dashboard.telemetry.tape import Place, Tape
from formation.faults import Fault
from formation.link_ids import LinkId
from formation.scenario.files import load
from network.messages import State, Status
from network.values import Event, LinkCounts, Motion, Pushed
from tests.builders import motion, state, status

SCENARIO = load("triangle-circle")


def at(stamp: float, **changes: Any) -> State:
    """Robots that drive along x at 1 m/s."""
    poses = np.array([[stamp, float(i), 0.1] for i in range(3)])
    fields = {"poses": poses, "slots": poses + 0.01, "distance_errors": np.full(3, 1e-3 * stamp), **changes}
    return state(stamp=stamp, **fields)


def told(stamp: float, episode: int = 0) -> Status:
    """Of robot 2, with everything that is drawn."""
    way = np.array([[1.0, 1.0, stamp, 0.5, 0.1, 1.0]])
    own = motion(begins=stamp, pose=np.array([stamp, 1.0, 0.2]))
    believes = Motion(stamp + 0.05, np.array([stamp, 0.1, 0.3]), 0.1, np.full((20, 2), 0.25))
    told_way = {"way": way, "way_age": 3.0, "lost": True, "lag": 0.5}
    counts = LinkCounts(sent=9, delivered=7, lost=2)
    return status(2, 1, stamp=stamp, episode=episode, age=0.02, plan=own, believes=believes, counts=counts, **told_way)


def recorded(tape: Tape, seconds: float, *, interval: float = 0.05, episode: int = 0, **changes: Any) -> None:
    """A run of so many seconds on the tape."""
    view = BeliefView(2, 1, np.zeros(3), np.zeros((21, 2)), np.array([0.03, 0.04]))
    for stamp in np.arange(0.0, seconds, interval):
        now = at(float(stamp), episode=episode, **changes)
        tape.add(now, SCENARIO, {2: told(float(stamp), episode)}, [view], now.poses + 0.5, HERE)


def test_a_moment_is_shown_again_as_it_was() -> None:
    tape = Tape()
    recorded(tape, 5.0)
    moment = tape.moment(Place(1, 3.04))
    assert moment is not None
    snapshot: Snapshot = moment.snapshot
    assert snapshot.state is not None
    then = at(3.04)
    np.testing.assert_allclose(snapshot.state.poses, then.poses, atol=1e-5)
    np.testing.assert_allclose(snapshot.state.slots, then.slots, atol=1e-5)
    np.testing.assert_allclose(snapshot.state.distance_errors, 1e-3 * 3.0 * np.ones(3), rtol=1e-5)
    assert moment.ghost is not None
    np.testing.assert_allclose(moment.ghost, then.poses + 0.5, atol=1e-5)
    np.testing.assert_allclose(moment.offsets[1], [0.03, 0.04])
    assert np.isnan(moment.offsets[[0, 2]]).all()
    (found,) = snapshot.statuses.values()
    was = told(3.0)
    assert (found.sender, found.link, found.counts, found.lost) == (2, was.link, was.counts, True)
    assert (found.age, found.way_age) == pytest.approx((0.02, 3.0))
    assert found.plan is not None
    assert found.believes is not None
    assert was.plan is not None
    assert found.plan.begins == pytest.approx(was.plan.begins, abs=1e-4)
    np.testing.assert_allclose(found.plan.inputs, was.plan.inputs, rtol=1e-3)
    np.testing.assert_allclose(found.way[-1, 2:4], [3.0, 0.5], atol=1e-5)
    assert found.lag == 0.5
    np.testing.assert_allclose(found.believes.pose, [3.0, 0.1, 0.3], atol=1e-5)
    np.testing.assert_allclose(found.believes.inputs, 0.25)


def test_memory_is_bounded_and_the_newest_is_kept() -> None:
    tape = Tape(seconds=120.0, most_bytes=1 << 30)
    recorded(tape, 400.0, interval=0.1)
    (episode,) = tape.episodes
    assert 120.0 <= episode.ends - episode.begins <= 150.0
    assert episode.ends == pytest.approx(399.9)
    small = Tape(seconds=1e6, most_bytes=tape.bytes // 2)
    recorded(small, 400.0, interval=0.1)
    assert small.bytes <= tape.bytes // 2
    assert small.episodes[0].ends == pytest.approx(399.9)


def test_a_reset_begins_another_episode_and_the_old_one_stays() -> None:
    tape = Tape()
    recorded(tape, 3.0)
    recorded(tape, 2.0, episode=1)
    recorded(tape, 1.0, episode=0)  # another world process, which numbers from 0 again
    assert [round(one.ends, 1) for one in tape.episodes] == [2.9, 1.9, 0.9]
    old = tape.moment(Place(1, 1.5))
    assert old is not None
    assert old.snapshot.stamp == pytest.approx(1.5)
    assert tape.nearest(Place(77, 1.0)) == Place(1, 0.0), "what is gone leads to the oldest"


def test_a_fault_and_a_lost_agent_are_marks_with_their_span() -> None:
    tape, cut = Tape(), {LinkId(1, 2): Fault(cut=True), LinkId(2, 3): Fault(cut=True)}
    for stamp in np.arange(0.0, 10.0, 0.1):
        faults = cut if 3.0 <= stamp < 5.0 else {}
        live = [1, 3] if stamp >= 7.0 else [1, 2, 3]
        events = (Event(1, 8.0, "fault", "said elsewhere"),) if stamp >= 8.0 else ()
        tape.add(at(float(stamp), faults=faults, live=live, events=events), SCENARIO, {}, [], None, HERE)
    found = [
        (mark.kind, round(mark.stamp, 1), mark.ends and round(mark.ends, 1), mark.label) for _, mark in tape.marks()
    ]
    assert found == [("cut", 3.0, 5.0, "2 links cut"), ("lost", 7.0, None, "R2 lost")]
    assert tape.mark_after(Place(1, 0.0)) == pytest.approx((1, 3.0))
    assert tape.mark_after(Place(1, 9.0), back=True) == pytest.approx((1, 7.0))
    assert tape.mark_after(Place(1, 9.0)) is None
    before = tape.moment(Place(1, 7.9))
    assert before is not None
    assert before.snapshot.state is not None
    assert before.snapshot.state.events == [], "what had not happened yet"
    assert before.snapshot.state.live == [1, 3]


def test_series_and_trace_show_the_largest_errors() -> None:
    tape = Tape()
    recorded(tape, 60.0)
    series = tape.series(1, 20.0, 40.0)
    assert series["t"][0] == pytest.approx(20.0)
    assert series["t"][-1] == pytest.approx(40.0)
    np.testing.assert_allclose(series["distance_max"], series["t"], rtol=1e-5)
    assert {len(column) for column in series.values()} == {len(series["t"])}
    trace = tape.trace()[1]
    assert trace[:, 1].max() == pytest.approx(0.0599, rel=0.01)


def test_the_playhead_plays_loops_and_returns() -> None:
    tape = Tape()
    recorded(tape, 5.0)
    head = Playhead(tape)
    assert head.place(0.0) is None
    assert head.tell(["go", "1", "2.0"])
    assert head.place(0.1) == Place(1, 2.0)
    head.tell(["play"])
    head.place(1.0)
    assert head.place(1.5) == pytest.approx((1, 3.4))
    head.tell(["step", "-1"])
    assert head.place(1.6) == pytest.approx((1, 2.4)), "a step stops it"
    head.tell(["live"])
    assert head.place(1.7) is None
    record = Playhead(tape, live=False)
    record.tell(["loop"])
    record.tell(["speed", "10.0"])
    record.place(0.0)
    assert record.place(0.3) == pytest.approx((1, 3.0))
    assert record.place(0.6) == Place(1, 0.0), "from the start again"
    record.tell(["live"])
    assert record.place(0.6) is not None, "a record has no present"


@pytest.mark.parametrize(
    "words",
    [[], ["go"], ["go", "1", "x"], ["go", "nan", "1"], ["go", "1", "1e400"], ["step", ""], ["speed", "7"], ["x"]],
)
def test_whatever_a_page_tells_is_harmless(words: list[str]) -> None:
    tape = Tape()
    recorded(tape, 1.0)
    head = Playhead(tape)
    head.tell(words)
    assert head.place(1.0) in (None, Place(1, 0.0))
    assert head.speed == 1.0


def test_faults_and_pushes_have_spans_and_those_that_act_go_on_to_the_end() -> None:
    feed = Tape()
    stuck = (Pushed(2, "stuck", 3.0),)
    begun = (Event(1, 1.0, "push", "robot 2: stuck for 2 s"),)
    cut = {LinkId(1, 2): Fault(cut=True)}
    for stamp, changes in (
        (0.0, {}),
        (1.0, {"events": begun, "pushes": stuck}),
        (2.0, {"events": begun, "pushes": stuck, "faults": cut}),
        (3.0, {"events": begun, "faults": cut}),
        (4.0, {"events": begun, "faults": cut}),
    ):
        feed.add(at(stamp, **changes), SCENARIO, {}, [], None, HERE)
    (episode,) = feed.episodes
    assert sorted(episode.marks.spans(episode.ends)) == [(1.0, 3.0), (2.0, 4.0)]
