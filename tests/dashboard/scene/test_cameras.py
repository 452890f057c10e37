"""Laws of the cameras: they show what was asked for, and what the user does to a camera is kept."""

import contextlib
import math
from collections.abc import Callable, Iterator, Sequence
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from dashboard.scene.cameras import FOV, HOLD_SECONDS, LOWER, TILT, Cameras
from formation.arrays import FloatArray
from formation.scenario.files import load


class _Camera:
    """Of a page, as this process has it."""

    def __init__(self) -> None:
        self.position: FloatArray = np.array([3.0, 3.0, 3.0])
        self.look_at: FloatArray = np.zeros(3)
        self.fov, self.aspect = 1.3, 0.8
        self.callback: Callable[[Any], None] = lambda _: None

    def on_update(self, callback: Callable[[Any], None]) -> None:
        self.callback = callback

    def dragged(self, position: FloatArray, look_at: FloatArray) -> None:
        """The page sends its pose."""
        self.position, self.look_at = position, look_at
        self.callback(self)


class _Client:
    def __init__(self) -> None:
        self.client_id, self.camera = 7, _Camera()

    @contextlib.contextmanager
    def atomic(self) -> Iterator[None]:
        yield


class _Clock:
    now = 100.0

    def __call__(self) -> float:
        return self.now


SCENARIO = load("triangle-circle")
LIVE = [1, 2, 3]
POSES = np.array([[0.8, 0.1, 1.5], [0.75, 0.0, 1.5], [0.85, 0.0, 1.5]])


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> _Clock:
    made = _Clock()
    monkeypatch.setattr("dashboard.scene.cameras.monotonic", made)
    return made


def opened() -> tuple[Cameras, Any]:
    """Views of a server, and a page that has just been opened."""
    connected: list[Callable[[Any], None]] = []
    server: Any = SimpleNamespace(
        initial_camera=_Camera(), on_client_connect=connected.append, on_client_disconnect=lambda _: None
    )
    cameras, client = Cameras(server), _Client()
    cameras.update(SCENARIO, POSES, LIVE)
    connected[0](client)
    return cameras, client


UPWARD = np.array([0.0, -TILT, 1.0])


def height(client: Any) -> float:
    """Of a camera above the ground [m]."""
    return float(client.camera.position[2])


def seen(client: Any) -> float:
    """Height of the view [m]."""
    return 2.0 * height(client) * math.tan(FOV / 2.0)


def pass_time(
    cameras: Cameras,
    clock: _Clock,
    seconds: float,
    step: float = 0.05,
    poses: FloatArray = POSES,
    live: Sequence[int] = LIVE,
) -> None:
    for _ in range(round(seconds / step)):
        clock.now += step
        cameras.update(SCENARIO, poses, live)


def test_a_page_that_sends_its_size_late_is_fitted_again(clock: _Clock) -> None:
    cameras, client = opened()
    cameras.fit(client)
    pass_time(cameras, clock, 0.5)
    first = client.camera.position.copy()
    client.camera.aspect = 0.4
    client.camera.callback(client.camera)  # an echo of what was sent
    pass_time(cameras, clock, 3.0)
    assert client.camera.position[2] > 1.5 * first[2]


@pytest.mark.parametrize("after", [0.05, 0.5, 1.0, 1.9])
def test_a_late_fit_does_not_undo_what_the_user_did(clock: _Clock, after: float) -> None:
    cameras, client = opened()
    cameras.fit(client)
    pass_time(cameras, clock, after)
    mine = client.camera.position + np.array([0.5, 0.0, -1.0])
    client.camera.dragged(mine, client.camera.look_at + np.array([0.5, 0.0, 0.0]))
    pass_time(cameras, clock, 3.0)
    np.testing.assert_array_equal(client.camera.position, mine)


def test_the_pages_pose_before_its_first_message_is_not_the_users(clock: _Clock) -> None:
    cameras, client = opened()
    client.camera.callback(client.camera)
    before = client.camera.position.copy(), client.camera.look_at.copy()
    pass_time(cameras, clock, 0.1)
    client.camera.dragged(*before)
    pass_time(cameras, clock, 3.0)
    assert client.camera.look_at[2] == 0.0
    np.testing.assert_allclose(client.camera.position - client.camera.look_at, height(client) * UPWARD, rtol=0.01)


def test_3d_stays_when_it_is_asked_for_at_once(clock: _Clock) -> None:
    cameras, client = opened()
    pass_time(cameras, clock, 0.1)
    cameras.tilt(client)
    tipped = client.camera.position.copy()
    pass_time(cameras, clock, 3.0)
    np.testing.assert_array_equal(client.camera.position, tipped)


def test_a_following_camera_keeps_the_offset_that_the_user_chose(clock: _Clock) -> None:
    cameras, client = opened()
    pass_time(cameras, clock, 0.1)
    cameras.follow(client, 1)
    turned = np.array([1.0, 1.0, 2.0])
    client.camera.dragged(client.camera.look_at + turned, client.camera.look_at)
    pass_time(cameras, clock, HOLD_SECONDS + 0.2)
    np.testing.assert_allclose(client.camera.look_at[:2], POSES[0, :2])
    np.testing.assert_allclose(client.camera.position - client.camera.look_at, turned)


def test_a_following_camera_does_not_turn_when_the_page_is_slow(clock: _Clock) -> None:
    """A message of the page, one move old, comes in between the two halves of the next move."""
    cameras, client = opened()
    pass_time(cameras, clock, 0.1)
    cameras.follow(client)
    offset = client.camera.position - client.camera.look_at
    stale = client.camera.position.copy(), client.camera.look_at.copy()
    camera = client.camera

    class Interrupted(_Camera):
        """Hears from the page right after its position was set, once."""

        interrupted = False

        def __setattr__(self, name: str, value: Any) -> None:
            object.__setattr__(self, name, value)
            if name == "position" and not self.interrupted and hasattr(self, "look_at"):
                object.__setattr__(self, "interrupted", True)
                object.__setattr__(self, "position", stale[0])
                object.__setattr__(self, "look_at", stale[1])

    client.camera.__class__ = Interrupted
    moved = POSES + np.array([0.3, 0.0, 0.0])
    cameras.update(SCENARIO, moved, LIVE)
    camera.callback(camera)
    clock.now += HOLD_SECONDS + 0.1
    cameras.update(SCENARIO, moved, LIVE)
    np.testing.assert_allclose(camera.position - camera.look_at, offset)


def test_a_page_begins_with_the_formation_in_a_fair_part_of_the_view(clock: _Clock) -> None:
    cameras, client = opened()
    client.camera.aspect = 1.2
    pass_time(cameras, clock, 3.0)
    spread = float(np.hypot(*np.ptp(POSES[:, :2], axis=0)))
    assert 0.2 < spread / seen(client) < 0.5
    middle = (POSES[:, :2].min(axis=0) + POSES[:, :2].max(axis=0)) / 2.0
    np.testing.assert_allclose(client.camera.look_at[:2], middle - [0.0, LOWER * seen(client)], atol=1e-3)


def test_the_camera_follows_the_robots_that_have_an_agent(clock: _Clock) -> None:
    cameras, client = opened()
    client.camera.aspect = 1.2
    gone = np.vstack([POSES[:2], [[90.0, 0.0, 0.0]]])
    pass_time(cameras, clock, 3.0, poses=gone, live=[1, 2])
    np.testing.assert_allclose(client.camera.look_at[0], gone[:2, 0].mean(), atol=0.05)
    pass_time(cameras, clock, 3.0, poses=gone, live=[])
    assert seen(client) > 90.0, "all of them, if nobody has one"


def test_the_zoom_follows_robots_apart_and_leaves_small_changes_alone(clock: _Clock) -> None:
    cameras, client = opened()
    client.camera.aspect = 1.2
    pass_time(cameras, clock, 3.0)
    before = seen(client)
    pass_time(cameras, clock, 3.0, poses=1.05 * POSES)
    assert seen(client) == pytest.approx(before, rel=1e-3)
    apart = POSES * np.array([4.0, 4.0, 1.0])
    pass_time(cameras, clock, 0.1, poses=apart)
    between = seen(client)
    pass_time(cameras, clock, 3.0, poses=apart)
    assert before < between < seen(client), "it eases"
    assert seen(client) > float(np.hypot(*np.ptp(apart[:, :2], axis=0)))


def test_the_zoom_that_a_user_chose_stays(clock: _Clock) -> None:
    cameras, client = opened()
    pass_time(cameras, clock, 0.5)
    mine = client.camera.look_at + 0.5 * (client.camera.position - client.camera.look_at)
    client.camera.dragged(mine, client.camera.look_at)
    chosen = height(client)
    pass_time(cameras, clock, 3.0, poses=POSES * np.array([4.0, 4.0, 1.0]))
    assert height(client) == pytest.approx(chosen)


def test_the_first_pose_of_a_page_that_is_very_slow_is_not_the_users(clock: _Clock) -> None:
    cameras, client = opened()
    start = np.array([3.0, 3.0, 3.0]), np.zeros(3)
    for size in (4.0, 1.0, 4.0, 1.0):  # the zoom has changed many times meanwhile
        pass_time(cameras, clock, 3.0, poses=POSES * np.array([size, size, 1.0]))
    client.camera.dragged(*start)
    pass_time(cameras, clock, 3.0)
    np.testing.assert_allclose(client.camera.position - client.camera.look_at, height(client) * UPWARD, rtol=0.01)


def test_a_camera_that_follows_is_moved_for_what_is_seen_and_for_nothing_less(clock: _Clock) -> None:
    cameras, client = opened()
    for _ in range(300):  # until its zoom is at rest
        clock.now += 0.1
        cameras.update(SCENARIO, POSES, LIVE)
    rest = client.camera.look_at.copy()
    cameras.update(SCENARIO, POSES + np.array([1e-4, 0.0, 0.0]), LIVE)
    np.testing.assert_array_equal(client.camera.look_at, rest)
    cameras.update(SCENARIO, POSES + np.array([5e-3, 0.0, 0.0]), LIVE)
    np.testing.assert_allclose(client.camera.look_at - rest, [5e-3, 0.0, 0.0], atol=1e-3)
