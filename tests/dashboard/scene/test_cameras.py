"""Laws of the links: they show what was asked for, and a person's hand comes first."""

import contextlib
from collections.abc import Callable, Iterator
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from dashboard.scene.cameras import HOLD_SECONDS, Cameras
from formation.arrays import FloatArray
from formation.scenario.files import load


class _Camera:
    """Of a page, as this process has it."""

    def __init__(self) -> None:
        self.position: FloatArray = np.array([3.0, 3.0, 3.0])
        self.look_at: FloatArray = np.zeros(3)
        self.fov, self.aspect = 1.3, 0.8
        self.told: Callable[[Any], None] = lambda _: None

    def on_update(self, told: Callable[[Any], None]) -> None:
        self.told = told

    def dragged(self, position: FloatArray, look_at: FloatArray) -> None:
        """The page says where it looks now."""
        self.position, self.look_at = position, look_at
        self.told(self)


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
    cameras.update(SCENARIO, POSES)
    connected[0](client)
    return cameras, client


def pass_time(cameras: Cameras, clock: _Clock, seconds: float, step: float = 0.05) -> None:
    for _ in range(round(seconds / step)):
        clock.now += step
        cameras.update(SCENARIO, POSES)


def test_a_page_that_tells_its_size_late_is_fitted_again(clock: _Clock) -> None:
    cameras, client = opened()
    pass_time(cameras, clock, 0.5)
    first = client.camera.position.copy()
    client.camera.aspect = 0.4
    client.camera.told(client.camera)  # an echo of what it was told
    pass_time(cameras, clock, 3.0)
    assert client.camera.position[2] > 1.5 * first[2]


@pytest.mark.parametrize("after", [0.05, 0.5, 1.0, 1.9])
def test_a_hand_on_the_camera_is_not_undone_by_a_late_fit(clock: _Clock, after: float) -> None:
    cameras, client = opened()
    pass_time(cameras, clock, after)
    mine = client.camera.position + np.array([0.5, 0.0, -1.0])
    client.camera.dragged(mine, client.camera.look_at + np.array([0.5, 0.0, 0.0]))
    pass_time(cameras, clock, 3.0)
    np.testing.assert_array_equal(client.camera.position, mine)


def test_what_the_page_looked_at_before_it_was_told_is_no_hand(clock: _Clock) -> None:
    cameras, client = opened()
    client.camera.told(client.camera)
    before = client.camera.position.copy(), client.camera.look_at.copy()
    pass_time(cameras, clock, 0.1)
    client.camera.dragged(*before)
    pass_time(cameras, clock, 3.0)
    assert client.camera.look_at[2] == 0.0
    assert client.camera.position[2] > 5.0, "from above"


def test_the_third_dimension_stays_when_it_is_asked_for_at_once(clock: _Clock) -> None:
    cameras, client = opened()
    pass_time(cameras, clock, 0.1)
    cameras.tilt(client)
    tipped = client.camera.position.copy()
    pass_time(cameras, clock, 3.0)
    np.testing.assert_array_equal(client.camera.position, tipped)


def test_a_following_view_goes_on_from_where_a_hand_left_it(clock: _Clock) -> None:
    cameras, client = opened()
    pass_time(cameras, clock, 0.1)
    cameras.follow(client, 1)
    turned = np.array([1.0, 1.0, 2.0])
    client.camera.dragged(client.camera.look_at + turned, client.camera.look_at)
    pass_time(cameras, clock, HOLD_SECONDS + 0.2)
    np.testing.assert_allclose(client.camera.look_at[:2], POSES[0, :2])
    np.testing.assert_allclose(client.camera.position - client.camera.look_at, turned)


def test_a_following_view_does_not_turn_when_the_page_is_slow(clock: _Clock) -> None:
    """The page's own word, one move old, comes in between the two halves of the next move."""
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
    cameras.update(SCENARIO, moved)
    camera.told(camera)
    clock.now += HOLD_SECONDS + 0.1
    cameras.update(SCENARIO, moved)
    np.testing.assert_allclose(camera.position - camera.look_at, offset)
