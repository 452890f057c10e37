"""Laws of what the dashboard shows, without a browser."""

import dataclasses
import logging
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from queue import SimpleQueue
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from dashboard.page import UNWATCHED_FRAME, Page
from dashboard.panels import faults, tables
from dashboard.panels.requests import RequestQueue
from dashboard.panels.summary import condition
from dashboard.scene import geometry
from dashboard.scene.layers import Sizes, arrows, held_plans, horizons, outline_colours, own_plans
from dashboard.serving import server
from dashboard.serving.access import Guard
from dashboard.serving.server import serve
from dashboard.telemetry.history import History
from dashboard.telemetry.links import LOST_SECONDS, LinkView, ring_links
from dashboard.telemetry.series import POINTS
from dashboard.telemetry.subscriber import TelemetrySubscriber
from dashboard.theme import colours, formatting
from dashboard.theme.palette import DARK, LIGHT
from formation import unicycle
from formation.faults import links_named
from formation.scenario.files import load
from network import topics
from network.codec import encode, seal
from network.control import Operation, Pause, SetFault
from network.messages import Event, LinkCounts, Reply, Setup
from network.zenoh_bus import Incoming, Router, Sample, Session, Wake
from tests.builders import plan, state, status

ROOT = Path(__file__).parents[2]


@given(
    st.lists(st.tuples(st.floats(-0.5, 0.5), st.floats(-2.0, 2.0)), min_size=1, max_size=20),
    st.tuples(st.floats(-5.0, 5.0), st.floats(-5.0, 5.0), st.floats(-3.0, 3.0)),
)
def test_a_plan_is_drawn_where_the_plant_would_go(
    inputs: list[tuple[float, float]], start: tuple[float, float, float]
) -> None:
    drawn = geometry.roll_out(np.array([start]), np.array([inputs]), 0.1)[0]
    pose = start
    for step, (v, omega) in enumerate(inputs, start=1):
        pose = unicycle.step(*pose, v, omega, 0.1)
        np.testing.assert_allclose(drawn[step], pose[:2], atol=1e-12)


def test_colours_come_out_of_the_tone_curve_as_they_were_asked_for() -> None:
    dark, light = ((p.ok, p.warn, p.bad, p.slot, p.background, p.identity[0]) for p in (DARK, LIGHT))
    for text in (*dark, *light, *LIGHT.identity):
        linear = colours.encode(colours.rgb(text)) / 255.0
        curve = (linear / 0.6) @ colours._INPUT.T
        curve = (curve * (curve + 0.0245786) - 0.000090537) / (curve * (0.983729 * curve + 0.4329510) + 0.238081)
        screen = np.clip(curve @ colours._OUTPUT.T, 0.0, 1.0)
        shown = np.where(screen <= 0.0031308, 12.92 * screen, 1.055 * screen ** (1 / 2.4) - 0.055)
        # The hue: a colour too bright for the curve comes out darker, one too pure a little paler.
        assert np.abs(shown - colours.rgb(text)).max() < 0.1, text
        if text in (DARK.background, LIGHT.background):
            assert np.abs(shown - colours.rgb(text)).max() < 0.005, "lines fade into it"


def test_every_target_of_the_fault_panel_is_made_of_links_that_the_world_knows() -> None:
    for robots in (2, 3, 16):
        for target in faults.targets(robots):
            for link in faults._links_of(target, robots):
                assert links_named(link, robots)


def test_the_panel_shows_the_worst_of_the_chosen_links() -> None:
    table = {"1->2": {"latency": 0.3}, "2->3": {"latency": 0.1, "cut": True}}
    assert faults.worst(table, ("1->2",), 3)["latency"] == 0.3
    assert not faults.worst(table, ("1->2",), 3)["cut"]
    every = faults.worst(table, ("all",), 3)
    assert (every["latency"], every["cut"]) == (0.3, True)


def test_the_belief_that_is_drawn_is_the_plan_that_the_neighbour_holds() -> None:
    said = {
        1: status(1, 3, plan=plan(1, 99), held=plan(3, 49)),
        2: status(2, 1, plan=plan(2, 99), held=plan(1, 7)),
        3: status(3, 2, plan=plan(3, 99, episode=1), held=plan(1, 8)),  # of another flight; of somebody else
    }
    numbers = [
        [None if p is None else (p.sender, p.seq) for p in plans(said, 3, 0)] for plans in (own_plans, held_plans)
    ]
    assert numbers == [[(1, 99), (2, 99), None], [(1, 7), None, (3, 49)]]


@pytest.mark.parametrize("robots", [2, 3, 20])
def test_an_arrow_runs_on_the_right_of_the_way_from_sender_to_receiver_and_is_dashed_when_lost(robots: int) -> None:
    poses = np.random.default_rng(robots).uniform(-0.5, 0.5, (robots, 3))
    now = state(robots, faults={"1->2": {"cut": True}})
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


def test_a_link_is_lost_when_it_is_cut_or_old_or_its_receiver_mute() -> None:
    now = state(stamp=1.0, faults={"1->2": {"cut": True}})
    said = {2: status(2, 1, age=0.1), 3: status(3, 2, age=LOST_SECONDS + 0.1), 1: status(1, 3, age=0.01)}
    assert [view.label for view in ring_links(now, said)] == ["CUT", "LOST", "OK"]
    assert [view.lost for view in ring_links(state(stamp=3.0), said)] == [True, True, True]
    assert [view.age for view in ring_links(state(episode=1), said)] == [None, None, None]


def test_history_begins_anew_with_a_flight_and_never_outgrows_the_plots() -> None:
    history = History()
    for tick in range(2 * POINTS):
        history.add(state(stamp=0.1 * tick), [])
    assert len(history.series()["t"]) == POINTS
    history.add(state(stamp=0.0, episode=1), [])
    history.add(state(stamp=0.1, episode=1), [])
    assert list(history.series()["t"]) == [0.0, 0.1]


def test_an_event_marks_its_time_once() -> None:
    history = History()
    history.add(state(stamp=1.0), [])
    event = Event(5, 1.15, "fault", "1->2: cut")
    for stamp in (1.2, 1.3, 1.4):
        history.add(state(stamp=stamp, events=(event,)), [])
    assert history.series()["event"].sum() == 1.0


def test_strings_from_elsewhere_are_escaped() -> None:
    evil = "<img src=x onerror=alert(1)>"
    said = state(events=(Event(1, 0.0, "fault", evil),), faults={evil: {"distribution": evil}})
    for html in (tables.log(said), tables.in_force(said), formatting.remark(evil)):
        assert "<img" not in html


def test_a_link_view_says_how_much_is_lost() -> None:
    assert LinkView(1, 2, 0.0, {}, LinkCounts(sent=10, lost=3)).loss == 0.3
    assert LinkView(1, 2, 0.0, {}, LinkCounts()).loss == 0.0


@pytest.mark.parametrize("port", ["-1", "65536", "http", ""])
def test_a_wrong_port_is_a_mistake_of_the_users(port: str) -> None:
    command = [sys.executable, "-m", "dashboard", "--run", "x", "--connect", "unixsock-stream/x", f"--port={port}"]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == 2
    assert "expected a port from 0 to 65535" in done.stderr


class _World:
    """Answers as a world does."""

    def __init__(self, reply: Reply | None, *, connected: bool = True) -> None:
        self.reply, self.connected, self.asked = reply, connected, list[Operation]()

    def ask(self, operation: Operation) -> Reply | None:
        self.asked.append(operation)
        return self.reply


class _Feed:
    def update_scenario(self) -> None:
        pass


def _requests(world: _World | Session, told: list[str]) -> RequestQueue:
    requests = RequestQueue(world, _Feed(), lambda page, title, text: told.append(f"{page} {title}: {text}"))  # type: ignore[arg-type]
    requests.start()
    return requests


def _wait(holds: Callable[[], bool]) -> None:
    end = time.monotonic() + 20.0
    while not holds():
        assert time.monotonic() < end
        time.sleep(0.01)


def test_a_refusal_is_told_to_the_page_that_asked() -> None:
    told: list[str] = []
    requests = _requests(_World(Reply(False, "latency: too long")), told)
    requests.ask(Pause(), 3)
    _wait(lambda: told == ["3 Not done: latency: too long"])
    requests.stop()


def test_silence_is_told_too() -> None:
    told: list[str] = []
    requests = _requests(_World(None), told)
    requests.ask(Pause(), 3)
    _wait(lambda: len(told) == 1 and "No answer: The world did not answer" in told[0])
    requests.stop()


def test_a_network_that_is_gone_is_told_as_such(tmp_path: Path) -> None:
    endpoint = f"unixsock-stream/{tmp_path}/router"
    router = Router(endpoint)
    told: list[str] = []
    with Session(endpoint, "x") as session:
        router.close()
        _wait(lambda: not session.connected)
        requests = _requests(session, told)
        requests.ask(Pause(), 3)
        _wait(lambda: len(told) == 1 and "The network is gone" in told[0])
        requests.stop()


def test_an_error_without_words_does_not_end_the_desk(caplog: pytest.LogCaptureFixture) -> None:
    class Broken(_World):
        def ask(self, operation: Operation) -> Reply | None:
            super().ask(operation)
            raise RuntimeError

    told: list[str] = []
    requests = _requests(Broken(None), told)
    requests.ask(Pause(), 3)
    requests.ask(Pause(), None)
    _wait(lambda: len(told) == 2)
    requests.stop()
    assert told == [f"{page} The world could not be asked: RuntimeError" for page in (3, None)]
    assert len(caplog.records) == 1


def test_of_a_dragged_slider_only_the_last_value_is_asked_for_and_in_order() -> None:
    world = _World(Reply(True))
    requests = _requests(world, [])
    for loss in (0.1, 0.2, 0.3):
        requests.change(("1->2", "2->3"), {"loss": loss}, None, 1)
    requests.ask(Pause(), 1)
    _wait(lambda: len(world.asked) == 3)
    requests.stop()
    assert world.asked[:2] == [SetFault(link=link, changes={"loss": 0.3}) for link in ("1->2", "2->3")]
    assert world.asked[2] == Pause()


class _Line:
    """A session on which a test says what comes in."""

    run, connected = "x", True

    def __init__(self) -> None:
        self.inbox: SimpleQueue[Incoming] = SimpleQueue()
        self.kept: dict[str, list[Sample]] = {}

    def keep(self, key: str, depth: int) -> Any:
        waiting = self.kept.setdefault(key, [])
        return SimpleNamespace(kept=waiting, take=lambda: iter([waiting.pop(0) for _ in list(waiting)]))

    def subscribe(self, key: str) -> None:
        pass

    def watch(self) -> None:
        pass

    def appear(self, role: str) -> None:
        pass

    def wake(self) -> None:
        self.inbox.put(Wake())

    def setup(self) -> Setup:
        return Setup(0, 0, 0.0, 0, 0, load("triangle-circle").model_dump_json(), "lockstep", {})


def _take(telemetry: TelemetrySubscriber, key: str, payload: bytes) -> bool:
    """Whether it was taken, not rejected."""
    before = telemetry._rejects.count
    telemetry._take(Sample(key, payload))
    return telemetry._rejects.count == before


@pytest.mark.parametrize(
    "changes",
    [
        {"stopped": [64]},
        {"live": [0]},
        {"waiting_for": [4]},
        {"dismissed": [4]},
        {"slots": np.zeros((2, 3))},
        {"faults": {"1->2": {"loss": "x"}}},
        {"faults": {"1->2": {"loss": 1.5}}},
        {"faults": {"1->2": {"cut": [[]]}}},
        {"faults": {"1->2": {"speed": 1.0}}},
    ],
)
def test_a_state_that_cannot_be_is_dropped(changes: dict[str, Any]) -> None:
    telemetry = TelemetrySubscriber(_Line())  # type: ignore[arg-type]
    assert _take(telemetry, topics.state("x"), encode(state()))
    assert not _take(telemetry, topics.state("x"), encode(state(stamp=2.0, **changes)))
    said = telemetry.snapshot().state
    assert said is not None
    assert said.stamp == 1.0


def test_faults_of_a_state_are_numbers_also_if_they_came_as_words() -> None:
    telemetry = TelemetrySubscriber(_Line())  # type: ignore[arg-type]
    assert _take(telemetry, topics.state("x"), encode(state(faults={"1->2": {"loss": "30%", "latency": 0.1}})))
    said = telemetry.snapshot().state
    assert said is not None
    assert said.faults == {"1->2": {"loss": 0.3, "latency": 0.1}}


def test_a_status_that_cannot_be_is_counted_and_dropped() -> None:
    line = _Line()
    telemetry = TelemetrySubscriber(line)  # type: ignore[arg-type]
    good = status(1, 3, plan=plan(1, 5))
    for sender, payload in (
        (1, encode(good)),
        (1, b"garbage"),
        (1, seal(b"whole, but no status")),
        (2, encode(good)),
    ):
        line.kept[topics.status("x", "*")].append(Sample(topics.status("x", sender), payload))
    said = telemetry.snapshot().statuses
    assert list(said) == [1]
    assert said[1].plan is not None
    assert said[1].plan.seq == 5
    assert telemetry._rejects.count == 3


@pytest.fixture
def page() -> Iterator[Page]:
    """A page of three robots that nobody looks at."""
    served = serve(Guard("127.0.0.1"), 0, "x")
    made = Page(served, _Line())  # type: ignore[arg-type]
    assert _take(made._telemetry, topics.state("x"), encode(state()))
    made._telemetry.update_scenario()
    assert made._frame() == 3
    yield made
    server.stop(served)


@pytest.mark.parametrize("choice", ["Robot ", "Robot x", "Robot -5: from and to", "", "9 → 1"])
def test_a_target_that_is_not_offered_is_no_link_and_is_set_back(page: Page, choice: str) -> None:
    panel = page._faults
    panel._target.value = choice
    assert list(panel.target) == []
    assert faults.worst({"1->2": {"loss": 1.0}}, panel.target, 3)["loss"] == 0.0
    panel.draw(state())
    assert list(panel.target) == ["all"]


@pytest.mark.parametrize("choice", ["Robot -5", "Robot 4", "Robot", ""])
def test_a_robot_that_is_not_offered_is_not_followed(page: Page, choice: str) -> None:
    client: Any = SimpleNamespace(client_id=1)
    page._focus_chosen(SimpleNamespace(client=client, target=SimpleNamespace(value=choice)))  # type: ignore[arg-type]
    for robot in (-4, 0, 4):
        page._focus_on(client, robot)
    assert page._scene.focus is None
    page._focus_on(client, 3)
    assert page._scene.focus == 3
    nobody = outline_colours(3, set(), set(), None, DARK)
    for focus in (-4, 0, 4):
        np.testing.assert_array_equal(outline_colours(3, set(), set(), focus, DARK), nobody)


def test_a_frame_that_cannot_be_drawn_does_not_end_the_page(
    page: Page, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    drawn: list[int] = []

    def frame() -> int:
        drawn.append(len(drawn))
        if len(drawn) <= 3:
            raise IndexError("odd value")
        return 3

    monkeypatch.setattr(page, "_frame", frame)

    class _Lifetime:
        @property
        def over(self) -> bool:
            return len(drawn) >= 6

    page.serve(_Lifetime())  # type: ignore[arg-type]
    assert len(drawn) == 6
    errors = [record for record in caplog.records if record.levelno == logging.ERROR]
    assert len(errors) == 1, "once a second"
    assert "drawing a frame" in errors[0].getMessage()


def test_who_waits_for_others_is_said_with_how_far_behind_it_is(page: Page) -> None:
    behind = dataclasses.replace(plan(2, 99), lag=1.26)
    for said in (status(1, 3, plan=plan(1, 99)), status(2, 1, plan=behind)):
        page._telemetry._waiting.kept.append(Sample(topics.status("x", said.sender), encode(said)))  # type: ignore[attr-defined]
    snapshot, views = page._keep()
    assert "1.3 s behind the clock" in condition(snapshot)[2]
    rows = tables.robots(snapshot, views, page._clickable).split("<tr")
    assert ["−1.3 s" in row for row in rows[2:]] == [False, True, False]


def test_a_page_that_nobody_looks_at_keeps_everything_and_draws_now_and_then(
    page: Page, monkeypatch: pytest.MonkeyPatch
) -> None:
    drawn: list[float] = []
    draw = page._frame

    def frame() -> int:
        drawn.append(time.monotonic())
        return draw()

    class _Lifetime:
        """Some moments, in each of which the world says something."""

        moments = 0

        @property
        def over(self) -> bool:
            self.moments += 1
            assert _take(page._telemetry, topics.state("x"), encode(state(stamp=1.0 + 0.2 * self.moments)))
            return self.moments > 25

    monkeypatch.setattr(page, "_frame", frame)
    page.serve(_Lifetime())  # type: ignore[arg-type]
    kept = page._export_buffer.data()
    assert kept is not None
    assert len(kept.t) >= 25, "every moment"
    assert drawn
    assert (np.diff(drawn) >= UNWATCHED_FRAME).all()


def test_the_first_frame_of_a_scenario_shows_everything(page: Page) -> None:
    nodes = page._scene._nodes
    assert nodes["/bodies"].batched_colors.max(axis=1).min() > 0, "none is black"
    assert nodes["/heads"].batched_colors.max(axis=1).min() > 0
    for name in ("/trails", "/horizons", "/beliefs", "/edges", "/links", "/desired"):
        assert nodes[name].points[..., 2].min() > 0.0, f"{name} has been lifted off the ground"


def test_what_a_dead_mind_said_last_is_forgotten_also_if_it_comes_late(page: Page) -> None:
    telemetry = page._telemetry
    waiting: list[Sample] = telemetry._waiting.kept  # type: ignore[attr-defined]
    waiting.append(Sample(topics.status("x", 2), encode(status(2, 1))))
    assert list(telemetry.snapshot().statuses) == [2]
    assert _take(telemetry, topics.state("x"), encode(state(stamp=1.1, live=[1, 3])))
    waiting.append(Sample(topics.status("x", 2), encode(status(2, 1))))
    snapshot, views = page._keep()
    assert not snapshot.statuses
    assert [(view.label, view.lost) for view in views] == [("LOST", True), ("...", False), ("...", False)]
    assert _take(telemetry, topics.state("x"), encode(state(stamp=1.2)))
    assert not telemetry.snapshot().statuses, "for good"


@pytest.mark.parametrize("elapsed", [0.0, 0.25, 1.0, 5.0])
def test_of_a_plan_that_was_told_a_while_ago_the_rest_is_drawn_from_where_the_robot_is(elapsed: float) -> None:
    poses, said = np.array([[3.0, 4.0, 0.5]]), plan(1, 100)
    ahead = horizons([said], poses, 20, said.stamp + elapsed)[0]
    left = max(0, 20 - int(elapsed / 0.1))
    np.testing.assert_allclose(ahead[0], [3.0, 4.0])
    np.testing.assert_allclose(np.hypot(*np.diff(ahead, axis=0).T) > 1e-9, np.arange(20) < left)
    np.testing.assert_allclose(horizons([said], poses, 20)[0, 0], said.pose[:2])
