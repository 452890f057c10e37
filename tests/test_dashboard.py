"""Laws of what the dashboard shows, without a browser."""

import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from websockets.datastructures import Headers

from dashboard import colours, faults, geometry, tables, words
from dashboard.desk import Desk
from dashboard.history import SERIES_POINTS, History
from dashboard.layers import held_plans
from dashboard.links import LOST_SECONDS, LinkView, links
from dashboard.plans import PlanLog
from dashboard.server import refused, serve
from formation import unicycle
from formation.errors import EchelonError
from formation.faults import links_named
from network.codec import encode
from network.control import Operation, Pause, SetFault
from network.messages import Event, LinkCounts, Plan, Reply, State, Status

ROOT = Path(__file__).parents[1]


def plan(sender: int, seq: int, epoch: int = 0) -> Plan:
    return Plan(sender, seq, 0.01 * seq, epoch, np.array([1.0, 2.0, 0.5]), 0.1, np.full((20, 2), 0.1))


def status(sender: int, upstream: int, *, belief: int = -1, age: float = 0.0, stamp: float = 1.0) -> Status:
    return Status(
        sender=sender,
        seq=100,
        stamp=stamp,
        epoch=0,
        link=f"{upstream}->{sender}",
        age=age,
        belief=belief,
        counts=LinkCounts(),
        solve=0.0,
        missed=0,
        gap=0.0,
        rejected=0,
        pid=1,
    )


def state(
    robots: int = 3, *, stamp: float = 1.0, epoch: int = 0, events: tuple[Event, ...] = (), **changes: object
) -> State:
    fields: dict[str, object] = {
        "sender": 0,
        "seq": 1,
        "stamp": stamp,
        "epoch": epoch,
        "revision": 0,
        "scenario": "triangle-circle",
        "controller": "nash",
        "mode": "lockstep",
        "status": "running",
        "waiting_for": [],
        "speed": 1.0,
        "pace": 1.0,
        "overruns": 0,
        "rejected": 0,
        "poses": np.zeros((robots, 3)),
        "slots": np.zeros((robots, 3)),
        "centre": np.zeros(3),
        "distance_errors": np.full(robots, 0.001),
        "angle_errors": np.zeros(robots),
        "tracking_error": 0.0,
        "live": list(range(1, robots + 1)),
        "stopped": [],
        "faults": {},
        "events": list(events),
    }
    return State(**{**fields, **changes})  # type: ignore[arg-type]


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
    for text in (colours.OK, colours.WARN, colours.BAD, colours.SLOT, colours.BACKGROUND, colours.IDENTITY[0]):
        linear = colours.encode(colours.rgb(text)) / 255.0
        curve = (linear / 0.6) @ colours._INPUT.T
        curve = (curve * (curve + 0.0245786) - 0.000090537) / (curve * (0.983729 * curve + 0.4329510) + 0.238081)
        screen = np.clip(curve @ colours._OUTPUT.T, 0.0, 1.0)
        shown = np.where(screen <= 0.0031308, 12.92 * screen, 1.055 * screen ** (1 / 2.4) - 0.055)
        # The hue: a colour too bright for the curve comes out darker, one too pure a little paler.
        assert np.abs(shown - colours.rgb(text)).max() < 0.1, text


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


@given(st.integers(1, 3), st.lists(st.booleans(), min_size=30, max_size=60))
def test_a_plan_is_found_by_its_number(step: int, arrived: list[bool]) -> None:
    log = PlanLog(1, 3)
    kept = [step * i for i, here in enumerate(arrived) if here]
    for seq in kept:
        log.add(encode(plan(1, seq)))
    for seq in kept[-5:]:
        found = log.numbered(seq, 0)
        assert found is None or found.seq == seq
    if all(arrived):
        assert all(log.numbered(seq, 0) is not None for seq in kept)
    assert log.numbered(10_000, 0) is None
    assert log.numbered(kept[-1] if kept else 0, 1) is None


def test_garbage_among_plans_is_passed_over() -> None:
    log = PlanLog(1, 3)
    log.add(b"garbage")
    assert log.newest() is None
    log.add(encode(plan(2, 1)))
    assert log.newest() is None
    log.add(encode(plan(1, 2)))
    assert log.newest() is not None


def test_the_belief_that_is_drawn_is_the_plan_that_the_neighbour_holds() -> None:
    logs = {i: PlanLog(i, 3) for i in (1, 2, 3)}
    for seq in range(50):
        for i, log in logs.items():
            log.add(encode(plan(i, seq)))
    held = held_plans(logs, {2: status(2, 1, belief=7), 1: status(1, 3, belief=49)}, 3, 0)
    assert [None if p is None else (p.sender, p.seq) for p in held] == [(1, 7), None, (3, 49)]


def test_a_link_is_lost_when_it_is_cut_or_old_or_its_receiver_mute() -> None:
    now = state(stamp=1.0, faults={"1->2": {"cut": True}})
    said = {2: status(2, 1, age=0.1), 3: status(3, 2, age=LOST_SECONDS + 0.1), 1: status(1, 3, age=0.01)}
    assert [view.word for view in links(now, said)] == ["CUT", "LOST", "OK"]
    assert [view.lost for view in links(state(stamp=3.0), said)] == [True, True, True]
    assert [view.age for view in links(state(epoch=1), said)] == [None, None, None]


def test_history_begins_anew_with_a_flight_and_never_outgrows_the_plots() -> None:
    history = History()
    for tick in range(2 * SERIES_POINTS):
        history.add(state(stamp=0.1 * tick), [])
    assert len(history.series()["t"]) == SERIES_POINTS
    history.add(state(stamp=0.0, epoch=1), [])
    history.add(state(stamp=0.1, epoch=1), [])
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
    for html in (tables.log(said), tables.in_force(said), words.remark(evil)):
        assert "<img" not in html


def test_a_link_view_says_how_much_is_lost() -> None:
    assert LinkView(1, 2, 0.0, {}, LinkCounts(sent=10, lost=3)).loss == 0.3
    assert LinkView(1, 2, 0.0, {}, LinkCounts()).loss == 0.0


@pytest.mark.parametrize(
    ("host", "origin", "ok"),
    [
        ("127.0.0.1:8090", "http://127.0.0.1:8090", True),
        ("localhost:8090", "http://localhost:8090", True),
        ("127.0.0.1:8090", "http://localhost:8090", False),
        ("127.0.0.1:8090", "http://evil.example", False),
        ("127.0.0.1:8090", "https://127.0.0.1:8090", False),
        ("127.0.0.1:8090", None, False),
        ("evil.example:8090", "http://evil.example:8090", False),
        ("127.0.0.1.evil.example:8090", "http://127.0.0.1.evil.example:8090", False),
    ],
)
def test_only_this_machines_own_pages_may_connect(host: str, origin: str | None, ok: bool) -> None:
    headers = Headers({"Host": host, "Upgrade": "websocket"})
    if origin is not None:
        headers["Origin"] = origin
    assert (refused(headers) is None) == ok


def test_other_hosts_than_loopback_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("ECHELON_IN_CONTAINER", raising=False)
    with pytest.raises(EchelonError, match=r"--host: expected one of 127\.0\.0\.1"):
        serve("0.0.0.0", 0, "x")


@pytest.mark.parametrize("port", ["-1", "65536", "http", ""])
def test_a_wrong_port_is_a_mistake_of_the_users(port: str) -> None:
    command = [sys.executable, "-m", "dashboard", "--run", "x", "--connect", "unixsock-stream/x", f"--port={port}"]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == 2
    assert "expected a port from 0 to 65535" in done.stderr


class _World:
    """Answers as a world does."""

    def __init__(self, reply: Reply | None) -> None:
        self.reply, self.asked = reply, list[Operation]()

    def ask(self, operation: Operation) -> Reply | None:
        self.asked.append(operation)
        return self.reply


class _Feed:
    def learn(self) -> None:
        pass


def _desk(world: _World, told: list[str]) -> Desk:
    desk = Desk(world, _Feed(), lambda page, title, text: told.append(f"{page} {title}: {text}"))  # type: ignore[arg-type]
    desk.start()
    return desk


def _wait(holds: Callable[[], bool]) -> None:
    end = time.monotonic() + 20.0
    while not holds():
        assert time.monotonic() < end
        time.sleep(0.01)


def test_a_refusal_is_told_to_the_page_that_asked() -> None:
    told: list[str] = []
    desk = _desk(_World(Reply(False, "latency: too long")), told)
    desk.ask(Pause(), 3)
    _wait(lambda: told == ["3 Not done: latency: too long"])
    desk.stop()


def test_silence_is_told_too() -> None:
    told: list[str] = []
    desk = _desk(_World(None), told)
    desk.ask(Pause(), 3)
    _wait(lambda: len(told) == 1 and "No answer" in told[0])
    desk.stop()


def test_of_a_dragged_slider_only_the_last_value_is_asked_for_and_in_order() -> None:
    world = _World(Reply(True))
    desk = _desk(world, [])
    for loss in (0.1, 0.2, 0.3):
        desk.change(("1->2", "2->3"), {"loss": loss}, None, 1)
    desk.ask(Pause(), 1)
    _wait(lambda: len(world.asked) == 3)
    desk.stop()
    assert world.asked[:2] == [SetFault(link=link, changes={"loss": 0.3}) for link in ("1->2", "2->3")]
    assert world.asked[2] == Pause()
