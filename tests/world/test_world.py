"""The ground truth: what stops a robot, what begins anew, what is told, and where noise comes from."""

# mypy: disable-error-code="arg-type, call-arg, comparison-overlap"
# (unpacked poses, numpy scalars and shapes; what strict typing of numpy makes of test arithmetic)

import hashlib
import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from formation.arrays import FloatArray
from formation.errors import FaultError, ScenarioError
from formation.faults import Fault
from formation.link_ids import LinkId, plan_links
from formation.metrics import pattern_errors, tracking_error
from formation.paths.path import heading
from formation.pattern import rotate, upstream
from formation.scenario.files import load
from formation.scenario.scenario import Scenario
from formation.unicycle import step
from network.codec import decode, encode
from network.messages import Command, State, Tick
from network.requests import Setup
from network.values import LinkCounts
from tests.builders import command, status
from world.bodies.wheeled import WheeledBodies
from world.command_links import WATCHDOG
from world.episode import SHOWN_EVENTS
from world.measures.trace import Trace
from world.world import World

TICK = 0.01


def world(*settings_: str, name: str = "triangle-circle", **more: Any) -> World:
    return World(load(name, settings_), **more)


def all_commands(w: World, **more: Any) -> dict[int, Command]:
    return {i: command(i, w.k, **more) for i in w.robots}


def simulate(w: World, ticks: int, **more: Any) -> None:
    for _ in range(ticks):
        w.advance(all_commands(w, **more))


def told(w: World, kind: str) -> list[str]:
    return [event.text for event in w.events if event.kind == kind]


# ---------------------------------------------------------------- stepping


def test_a_tick_moves_every_body_by_its_command() -> None:
    w = world()
    before = w.plant.poses
    w.advance({1: command(1, 0, 0.1, 0.2), 2: command(2, 0, -0.1, 0.0), 3: command(3, 0, 0.0, 1.0)})
    for row, (v, omega) in enumerate([(0.1, 0.2), (-0.1, 0.0), (0.0, 1.0)]):
        np.testing.assert_array_equal(w.plant.poses[row], step(*before[row], v, omega, TICK))
    assert (w.k, w.now) == (1, TICK)


@given(st.floats(-1e6, 1e6), st.floats(-1e6, 1e6))
@settings(max_examples=30)
def test_a_body_cannot_do_more_than_its_limits(v: Any, omega: Any) -> None:
    w = world()
    before = w.plant.poses
    w.advance({1: command(1, 0, v, omega)})
    expected = step(*before[0], max(-0.5, min(v, 0.5)), max(-2.0, min(omega, 2.0)), TICK)
    np.testing.assert_array_equal(w.plant.poses[0], expected)


def test_a_robot_that_says_nothing_goes_on_with_its_newest_command() -> None:
    w = world()
    w.advance({1: command(1, 0, 0.1, 0.0)})
    before = w.plant.poses[0]
    w.advance({})
    np.testing.assert_array_equal(w.plant.poses[0], step(*before, 0.1, 0.0, TICK))


def test_the_tick_message_says_where_and_when_and_who_planned() -> None:
    w = world()
    simulate(w, 2)
    w.advance({1: command(1, 2), 3: command(3, 2, planned=False)})
    tick = w.tick()
    assert (tick.sender, tick.seq, tick.stamp, tick.planned) == (0, 3, pytest.approx(0.03), [1])
    np.testing.assert_array_equal(tick.poses, w.plant.poses)
    assert w.tick() is tick
    assert decode(Tick, encode(tick)).planned == [1]


def test_the_last_tick_is_marked_and_the_episode_then_ends() -> None:
    w = world("duration=0.03")
    marks = []
    while not w.finished:
        marks.append(w.tick().last)
        w.advance({})
    assert marks == [False, False, True]


# ---------------------------------------------------------------- the watchdog


def test_a_robot_without_a_fresh_command_stops_after_a_while_with_one_event() -> None:
    w = world()
    simulate(w, 10)
    patience = round(WATCHDOG / TICK)
    moved = []
    for _ in range(3 * patience):
        before = w.plant.poses[0]
        w.advance({i: command(i, w.k) for i in (2, 3)})
        moved.append(bool(np.any(w.plant.poses[0] != before)))
    assert moved == [True] * patience + [False] * 2 * patience
    assert told(w, "watchdog") == ["robot 1 stopped: no fresh command"]
    assert w.state(seq=0, status="running").stopped == [1]
    simulate(w, 1)
    assert told(w, "watchdog")[1:] == ["robot 1 moves again"]
    assert w.state(seq=0, status="running").stopped == []
    simulate(w, 30)
    assert len(told(w, "watchdog")) == 2


def test_who_never_spoke_is_told_as_stopped_once() -> None:
    w = world()
    before = w.plant.poses
    for _ in range(100):
        w.advance({})
    np.testing.assert_array_equal(w.plant.poses, before)
    assert told(w, "watchdog") == [f"robot {i} stopped: no fresh command" for i in (1, 2, 3)]


def test_a_cut_command_link_stops_the_robot() -> None:
    w = world('faults=[{at=0.5, until=1.5, link="2->world", cut=true}]')
    simulate(w, 75)
    before = w.plant.poses
    simulate(w, 50)
    np.testing.assert_array_equal(w.plant.poses[1], before[1])
    assert np.all(w.plant.poses[0] != before[0])
    simulate(w, 50)
    assert told(w, "watchdog") == ["robot 2 stopped: no fresh command", "robot 2 moves again"]
    assert np.any(w.plant.poses[1] != before[1])


def test_a_late_command_link_moves_the_robot_later() -> None:
    w = world()
    w.change_fault("1->world", {"latency": "100ms"}, None)
    start = w.plant.poses
    simulate(w, 10)
    np.testing.assert_array_equal(w.plant.poses[0], start[0])
    simulate(w, 1)
    np.testing.assert_array_equal(w.plant.poses[0], step(*start[0], 0.1, 0.2, TICK))


def test_a_damaged_command_is_not_obeyed() -> None:
    w = world()
    w.change_fault("1->world", {"corrupt": 1.0}, None)
    start = w.plant.poses
    simulate(w, 30)
    np.testing.assert_array_equal(w.plant.poses[0], start[0])


# ---------------------------------------------------------------- a new episode


def test_reset_starts_a_new_epoch_at_time_zero_with_the_same_poses() -> None:
    w = world("robots.start_noise.position=0.02", "noise.slip=0.2")
    start, first = w.plant.poses, w.tick()
    simulate(w, 50)
    once = w.plant.poses
    revision = w.revision
    w.reset()
    assert (w.k, w.now, w.episode) == (0, 0.0, first.episode + 1)
    assert w.revision > revision
    np.testing.assert_array_equal(w.plant.poses, start)
    tick = w.tick()
    assert (tick.seq, tick.stamp, tick.episode, tick.planned) == (0, 0.0, first.episode + 1, [])
    simulate(w, 50, episode=w.episode)
    np.testing.assert_array_equal(w.plant.poses, once)  # the noise is the same again
    assert told(w, "run")[-1] == "reset"


def test_reset_keeps_what_people_set_without_an_end_and_forgets_figures_and_held_robots() -> None:
    w = world('faults=[{at=0.1, link="1->2", loss=0.5}]')
    simulate(w, 20)
    w.change_fault("2->3", {"latency": 0.1}, None)
    w.change_fault("3->1", {"cut": True}, 100.0)
    for _ in range(40):
        w.advance({})
    w.live = {1, 2}
    assert w.state(seq=0, status="running").stopped == [1, 2, 3]
    w.reset()
    assert w.faults.table == {LinkId(2, 3): Fault(latency=0.1)}
    assert w.state(seq=0, status="running").stopped == []
    assert w.summary()["ticks"] == 0
    assert w.live == {1, 2}
    simulate(w, 11, episode=1)
    assert w.faults.table == {LinkId(1, 2): Fault(loss=0.5), LinkId(2, 3): Fault(latency=0.1)}


def test_another_scenario_begins_another_episode() -> None:
    w = world()
    simulate(w, 10)
    w.change_fault("1->2", {"loss": 0.5}, None)
    w.live = {1, 2, 3}
    w.use(load("figure8"))
    assert (w.k, w.episode, list(w.robots), w.live) == (0, 1, [1, 2], {1, 2})
    assert w.faults.table == {}
    assert "figure8" in told(w, "run")[-1]


# ---------------------------------------------------------------- faults


def test_a_fault_takes_effect_at_a_named_tick_with_a_new_revision_and_an_event() -> None:
    w = world('faults=[{at=0.05, until=0.08, link="1->2", loss=0.5}]')
    revisions = []
    for _ in range(10):
        revisions.append(w.tick().revision)
        w.advance(all_commands(w))
    assert revisions == [0] * 5 + [1] * 3 + [2] * 2
    assert [(e.stamp, e.text) for e in w.events if e.kind == "fault"] == [
        (pytest.approx(0.05), "1->2: loss 50 %"),
        (pytest.approx(0.08), "1->2: healthy"),
    ]


def test_what_people_change_is_named_by_the_next_tick() -> None:
    w = world()
    first = w.tick()
    w.advance(all_commands(w))
    w.change_fault("all", {"loss": "30%"}, None)
    second = w.tick()
    assert second.revision == w.revision == w.setup().revision > first.revision
    assert set(w.setup().faults) == set(plan_links(3))
    w.advance(all_commands(w))
    assert w.tick().revision == second.revision
    w.clear_faults("all")
    assert w.setup().faults == {}
    assert w.revision > second.revision


def test_a_wrong_change_of_a_fault_leaves_revision_and_events_alone() -> None:
    w = world()
    before = len(w.events)
    with pytest.raises(FaultError):
        w.change_fault("1->3", {"loss": 0.5}, None)
    with pytest.raises(FaultError):
        w.change_fault("all", {"los": 0.5}, None)
    assert (w.revision, len(w.events), w.faults.table) == (0, before, {})


# ---------------------------------------------------------------- what it tells


def test_state_and_setup_go_over_the_wire_and_come_back() -> None:
    w = world("link.loss=0.25", "noise.slip=0.1")
    simulate(w, 30)
    state = w.state(seq=7, status="running", speed=1.0, pace=0.9, overruns=2, rejected=3, waiting_for=[2])
    again = decode(State, encode(state))
    assert (again.seq, again.stamp, again.status, again.waiting_for) == (7, pytest.approx(0.3), "running", [2])
    np.testing.assert_array_equal(again.poses, w.plant.poses)
    assert again.faults == dict.fromkeys(plan_links(3), Fault(loss=0.25))
    assert [e.text for e in again.events] == [e.text for e in w.events]
    setup = decode(Setup, encode(w.setup()))
    assert Scenario.model_validate_json(setup.scenario).model_dump() == w.scenario.model_dump()
    assert (setup.episode, setup.revision, setup.faults) == (w.episode, w.revision, again.faults)


def slots(scenario: Scenario, t: FloatArray) -> FloatArray:
    """The formation (..., n, 2) along the path, as the paper samples its heading."""
    turned = rotate(heading(scenario.path, t, 0.1)[..., None], scenario.formation.array)
    return scenario.path.position(t)[..., None, :] + turned


def test_the_state_shows_the_errors_of_now() -> None:
    w = world()
    simulate(w, 40)
    state = w.state(seq=0, status="running")
    distance, angle = pattern_errors(w.plant.poses, slots(w.scenario, np.array(0.4)))
    np.testing.assert_allclose(state.distance_errors, distance, atol=1e-12)
    np.testing.assert_allclose(state.angle_errors, angle, atol=1e-9)
    centre = w.scenario.path.position(np.array(0.4))
    np.testing.assert_allclose(state.centre[:2], centre, atol=1e-12)
    assert state.tracking_error == pytest.approx(tracking_error(w.plant.poses, centre))
    assert np.abs(distance).max() > 1e-4


def test_the_state_carries_the_newest_events_only() -> None:
    w = world()
    for n in range(SHOWN_EVENTS + 10):
        w.event("run", f"event {n}")
    texts = [event.text for event in w.state(seq=0, status="running").events]
    assert texts == [f"event {n}" for n in range(10, SHOWN_EVENTS + 10)]
    numbers = [event.number for event in w.events]
    assert numbers == sorted(set(numbers))


def test_a_status_of_another_episode_or_of_no_robot_is_ignored() -> None:
    w = world()

    counts = LinkCounts(sent=5)
    for sender, episode in ((1, 1), (4, 0), (0, 0)):
        w.hear(status(sender, upstream(sender, 3), episode=episode, counts=counts))
    assert w.statuses == {}
    assert w.counts == {}
    w.hear(status(1, 3, counts=counts))
    assert set(w.statuses) == {1}
    assert w.counts == {LinkId(3, 1): LinkCounts(sent=5)}


@pytest.mark.parametrize("link", [LinkId(1, 9), LinkId(2, 1), LinkId(0, 1)])
def test_a_status_about_a_link_that_is_not_its_senders_does_not_spoil_the_summary(link: Any) -> None:
    w = world()
    simulate(w, 3)
    w.hear(status(1, 3, link=link, counts=LinkCounts(sent=5)))
    assert w.summary()["links"] == {}


# ---------------------------------------------------------------- figures


def test_the_summary_is_what_a_direct_computation_gives() -> None:
    w = world("duration=0.6", "noise.slip=0.2")
    poses, ages = [w.plant.poses], []
    generator = np.random.default_rng(0)
    while not w.finished:
        commands = {
            i: command(i, w.k, *generator.uniform(-0.3, 0.3, 2), age=float(generator.random()), solve=0.001 * i)
            for i in w.robots
        }
        ages.append([commands[i].age for i in w.robots])
        w.advance(commands)
        poses.append(w.plant.poses)
    w.hear(status(1, 3, counts=LinkCounts(9, 7, 2, 1)))
    for warmup, first in ((0.0, 0), (0.25, 25)):
        s = w.summary(warmup=warmup)
        track = np.array(poses)
        t = np.arange(first, 61) * TICK
        distance, angle = pattern_errors(track[first:], slots(w.scenario, t))
        off = tracking_error(track[first:], w.scenario.path.position(t))
        measures = [
            (s["robots"][str(i + 1)][key], values[:, i])
            for i in range(3)
            for key, values in (("distance_error_m", distance), ("angle_error_rad", angle))
        ]
        for got, values in [*measures, (s["tracking_error_m"], off)]:
            size = np.sort(np.abs(values))
            assert got["rms"] == pytest.approx(math.sqrt(sum(v * v for v in values) / len(values)))
            assert got["max"] == size[-1]
            assert got["final"] == values[-1]
            for key, share in (("q1", 0.25), ("median", 0.5), ("q3", 0.75), ("p95", 0.95)):
                assert got[key] == pytest.approx(np.percentile(size, 100 * share))
        own = np.array(ages)[first:, 0]
        link = s["links"]["3->1"]
        assert (link["sent"], link["delivered"], link["lost"], link["late"]) == (9, 7, 2, 1)
        assert link["age_s"] == {
            "median": pytest.approx(np.median(own)),
            "p95": pytest.approx(np.percentile(own, 95)),
            "max": own.max(),
        }
        assert s["solve_s"]["median"] == pytest.approx(0.002)
        assert (s["ticks"], s["seed"], s["scenario"], s["controller"]) == (60, 0, "triangle-circle", "nash")
        assert (s["duration"], s["warmup"]) == (pytest.approx(0.6), pytest.approx(warmup))
        # The sha is of the whole episode, whatever the warm-up.
        assert s["trajectory_sha256"] == hashlib.sha256(track.astype("<f8").tobytes()).hexdigest()
        assert s["events"] == [{"t": e.stamp, "kind": e.kind, "severity": e.severity, "text": e.text} for e in w.events]


def test_an_episode_that_has_not_begun_has_a_summary_without_ages() -> None:
    s = world().summary()
    assert s["ticks"] == 0
    assert s["solve_s"] == {"median": None, "p99": None}


def test_a_warmup_longer_than_the_episode_measures_its_last_pose() -> None:
    w = world()
    simulate(w, 5)
    s = w.summary(warmup=100.0)
    assert s["warmup"] == pytest.approx(0.05)
    one = s["robots"]["1"]["distance_error_m"]
    assert one["rms"] == one["max"] == abs(one["final"])


def test_a_trace_is_full_at_its_last_tick() -> None:
    scenario = load("circle")
    trace = Trace(scenario, 2, scenario.reference())
    trace.start(np.zeros((2, 3)))
    for full in (False, True):
        assert not trace.full
        trace.add(np.zeros((2, 3)), np.zeros((2, 2)), {}, [])
        assert trace.full is full


def test_an_endless_episode_goes_on_where_the_path_is_closed_and_keeps_no_figures() -> None:
    w = world("duration=0.05", endless=True)
    simulate(w, 10)
    assert not w.finished
    assert not w.tick().last
    assert w.summary() == {}
    open_path = world("duration=0.05", name="sinusoid", endless=True)
    simulate(open_path, 5)
    assert open_path.finished


# ---------------------------------------------------------------- noise


def plant(*settings_: str) -> WheeledBodies:
    return WheeledBodies(load("triangle-circle", settings_))


def seen(p: WheeledBodies) -> FloatArray:
    """Poses (n, 3) as localisation measures them now."""
    measured = p.measure()
    assert measured is not None
    return measured.poses


def rolled(p: WheeledBodies, ticks: int = 20) -> FloatArray:
    for _ in range(ticks):
        p.move(np.array([[0.1, 0.2]] * 3))
    return p.poses


def test_noise_is_seeded() -> None:
    noisy = ["noise.slip=0.2", "noise.gyro=0.1", "noise.position=0.01", "noise.heading=0.1"]
    a, b, c = plant(*noisy), plant(*noisy), plant(*noisy, "seed=1")
    np.testing.assert_array_equal(rolled(a), rolled(b))
    assert np.all(a.poses != rolled(c))
    np.testing.assert_array_equal(seen(a), seen(b))
    assert np.all(seen(a) != a.poses)


def test_measuring_does_not_change_how_the_bodies_slip() -> None:
    quiet, watched = plant("noise.slip=0.2"), plant("noise.slip=0.2", "noise.position=0.01")
    for _ in range(20):
        quiet.move(np.array([[0.1, 0.2]] * 3))
        watched.measure()
        watched.move(np.array([[0.1, 0.2]] * 3))
    np.testing.assert_array_equal(watched.poses, quiet.poses)


def test_slipping_does_not_change_how_poses_are_measured() -> None:
    still, slipping = plant("noise.position=0.01"), plant("noise.position=0.01", "noise.slip=0.2", "noise.gyro=0.2")
    for _ in range(5):
        blur = [seen(p) - p.poses for p in (still, slipping)]
        np.testing.assert_allclose(blur[0], blur[1], atol=1e-15)  # the same draws, added to other poses
        assert np.abs(blur[0]).max() > 1e-4
        for p in (still, slipping):
            p.move(np.array([[0.1, 0.2]] * 3))


def test_the_slip_does_not_depend_on_the_inputs() -> None:
    a, b = plant("noise.gyro=0.2"), plant("noise.gyro=0.2")
    start = a.poses
    for _ in range(10):
        a.move(np.array([[0.0, 0.0]] * 3))
        b.move(np.array([[0.3, 0.5]] * 3))
    turn = b.poses[:, 2] - start[:, 2] - 10 * TICK * 0.5
    np.testing.assert_allclose(a.poses[:, 2] - start[:, 2], turn, atol=1e-12)
    assert np.abs(turn).min() > 1e-5


def test_the_noise_has_the_size_asked_for() -> None:
    p = plant("noise.position=0.003", "noise.heading=0.02")
    errors = []
    for _ in range(2000):
        errors.append(seen(p) - p.poses)
        p.move(np.array([[0.1, 0.2]] * 3))
    blur = np.array(errors)
    np.testing.assert_allclose(blur.std(axis=(0, 1)), [0.003, 0.003, 0.02], rtol=0.05)  # 6000 draws: 1 % spread
    q = plant("noise.slip=0.2", "noise.gyro=0.3")
    turns = []
    for _ in range(2000):
        before = q.poses
        q.move(np.array([[0.1, 1.0]] * 3))
        turns.append((q.poses - before)[:, 2] / TICK)
    assert np.std(turns) == pytest.approx(math.hypot(0.2, 0.3), rel=0.05)
    assert np.mean(turns) == pytest.approx(1.0, abs=0.02)


def test_without_noise_what_is_measured_is_true() -> None:
    p = plant()
    np.testing.assert_array_equal(seen(p), p.poses)
    assert not p.poses.flags.writeable


def test_a_stuck_robot_stands_still_and_a_slowed_one_does_its_share() -> None:
    w = world("disturbances=[{robot=2, at=0.1, until=0.2, drive=0.0}, {robot=3, at=0.1, until=0.2, drive=0.5}]")
    free = world()
    simulate(w, 10)
    simulate(free, 10)
    np.testing.assert_array_equal(w.plant.poses, free.plant.poses)  # nothing has begun
    before = w.plant.poses
    simulate(w, 10)
    simulate(free, 10)
    np.testing.assert_array_equal(w.plant.poses[1], before[1])
    np.testing.assert_array_equal(w.plant.poses[0], free.plant.poses[0])
    assert w.plant.poses[2, 2] - before[2, 2] == pytest.approx(0.5 * (free.plant.poses[2, 2] - before[2, 2]))
    before = w.plant.poses
    simulate(w, 1)
    assert math.dist(w.plant.poses[1, :2], before[1, :2]) == pytest.approx(0.1 * TICK)  # released


def test_a_push_carries_a_robot_beyond_its_own_motion() -> None:
    w = world("disturbances=[{robot=1, at=0.0, until=0.5, drift=[0.1, -0.2, 0.3]}]")
    start = w.plant.poses
    for _ in range(60):
        w.plant.move(np.zeros((3, 2)))
    np.testing.assert_allclose(w.plant.poses - start, [[0.05, -0.1, 0.15], [0, 0, 0], [0, 0, 0]], atol=1e-12)


@pytest.mark.parametrize(
    ("entry", "words"),
    [
        ("{robot=4, at=1, until=2, drive=0.0}", ["disturbances[0].robot", "1 to 3", "4"]),
        ("{robot=1, at=2, until=1, drive=0.0}", ["until > at"]),
        ("{robot=1, until=1}", ["drive below 1, a speed, a drift, slip, or blind"]),
        ("{robot=1, until=1, drive=2.0}", ["disturbances[0].drive"]),
    ],
)
def test_a_wrong_disturbance_is_named(entry: Any, words: Any) -> None:
    with pytest.raises(ScenarioError) as caught:
        load("triangle-circle", [f"disturbances=[{entry}]"])
    assert all(word in str(caught.value) for word in words)
