"""The cameras of all pages: fit, 3D, follow the formation or one robot. Each page has its own.

The camera is in perspective with a narrow angle: from above it looks flat, and it can be tilted into 3D.
"""

import math
import threading
from collections import deque
from dataclasses import dataclass, field
from time import monotonic
from typing import Any

import numpy as np
import viser

from dashboard.scene.path_line import path_points
from formation.arrays import FloatArray
from formation.scenario.scenario import Scenario

FOV = math.radians(12.0)
TILT = 0.004
"""From the vertical [rad]: straight down, the up direction would be undefined."""
WIDE_METRES = 4.0
"""On longer paths the robots would be dots: then the camera follows them from the start [m]."""
MARGIN = 1.12
HOLD_SECONDS = 0.4
"""A following camera rests so long after a user moved it, then follows with the new offset [s]."""
TRIES = 4
"""To read or write a camera while its page sends another pose."""
ASPECT = 1.1
"""Width by height of the canvas, until the page has sent its own."""


@dataclass(slots=True)
class _PageCamera:
    """The camera of one page."""

    client: viser.ClientHandle
    target: int | None = None
    """Robot that is followed, 0 for the formation; None if nothing is."""
    offset: FloatArray = field(default_factory=lambda: np.array([0.0, 0.0, 1.0]))
    """From the point that the camera looks at to the camera [m]."""
    set_at: float = 0.0
    rest_until: float = 0.0
    fit_at: list[float] = field(default_factory=list)
    """When to fit again: the page sends its size late [s]."""
    ours: deque[tuple[FloatArray, FloatArray]] = field(default_factory=lambda: deque(maxlen=6))
    """Points looked at and offsets last sent to the page: one that differs comes from the user [m]."""


class Cameras:
    """Moves the cameras of all pages."""

    def __init__(self, server: viser.ViserServer) -> None:
        self._server = server
        self._lock = threading.RLock()
        self._pages: dict[int, _PageCamera] = {}
        self._scenario: Scenario | None = None
        self._poses: FloatArray = np.zeros((1, 3))
        self._set_home(np.zeros(3), 3.0)
        server.on_client_connect(self._connected)
        server.on_client_disconnect(self._gone)

    def _set_home(self, centre: FloatArray, height: float) -> None:
        camera = self._server.initial_camera
        distance = 0.5 * MARGIN * height / math.tan(FOV / 2.0)
        x, y = float(centre[0]), float(centre[1])
        camera.position = (x, y - TILT * distance, distance)
        camera.look_at = (x, y, 0.0)
        camera.up = (0.0, 0.0, 1.0)
        camera.fov = FOV

    # ------------------------------------------------------------------ from the user

    def fit(self, client: viser.ClientHandle) -> None:
        """Show the whole path from above."""
        with self._lock:
            page = self._pages.get(client.client_id)
            if page is not None:
                page.target = None
                page.fit_at = [monotonic(), monotonic() + 0.4]

    def tilt(self, client: viser.ClientHandle) -> None:
        """Look at the same point from the side."""
        with self._lock:
            page = self._pages.get(client.client_id)
            if page is None:
                return
            page.fit_at = []
            look_at = np.array(client.camera.look_at)
            distance = float(np.linalg.norm(np.array(client.camera.position) - look_at))
            self._move(page, look_at, 0.92 * distance * np.array([-0.30, -0.66, 0.69]))

    def follow(self, client: viser.ClientHandle, target: int = 0) -> None:
        """Keep a robot, or the formation (0), in the middle."""
        with self._lock:
            page = self._pages.get(client.client_id)
            if page is not None:
                self._follow(page, target)

    def _follow(self, page: _PageCamera, target: int) -> None:
        page.target = target
        page.fit_at = []
        distance = 0.5 * self._follow_height() / math.tan(FOV / 2.0)
        self._move(page, self._centre(target), distance * np.array([0.0, -TILT, 1.0]))

    def release(self, client: viser.ClientHandle) -> None:
        """Follow nothing."""
        with self._lock:
            page = self._pages.get(client.client_id)
            if page is not None:
                page.target = None

    # ------------------------------------------------------------------ every frame

    def update(self, scenario: Scenario, poses: FloatArray) -> None:
        """Move the cameras that follow."""
        with self._lock:
            self._poses = poses
            if scenario is not self._scenario:
                known, self._scenario = self._scenario, scenario
                if known is None or known.path != scenario.path or known.size != scenario.size:
                    self._begin(scenario)
            now = monotonic()
            for page in self._pages.values():
                if page.fit_at and now >= page.fit_at[0]:
                    page.fit_at.pop(0)
                    self._fit(page, scenario)
                elif page.target is not None and now >= page.rest_until:
                    self._move(page, self._centre(page.target), page.offset)

    def _begin(self, scenario: Scenario) -> None:
        low, high = _bounds(scenario)
        width, height = high - low
        if self._wide(scenario):
            self._set_home(self._centre(0), self._follow_height())
        else:
            self._set_home((low + high) / 2.0, max(height, width / ASPECT))
        for page in self._pages.values():
            self._first(page)

    def _first(self, page: _PageCamera) -> None:
        if self._scenario is not None and self._wide(self._scenario):
            self._follow(page, 0)
        else:
            page.target = None
            page.fit_at = [monotonic() + pause for pause in (0.0, 0.7, 2.0)]

    def _fit(self, page: _PageCamera, scenario: Scenario) -> None:
        if scenario.driven:  # there is no path to be shown before it is driven
            self._follow(page, 0)
            return
        low, high = _bounds(scenario)
        aspect = page.client.camera.aspect
        width, height = high - low
        distance = 0.5 * MARGIN * max(height, width / aspect) / math.tan(FOV / 2.0)
        self._move(page, np.append((low + high) / 2.0, 0.0), distance * np.array([0.0, -TILT, 1.0]))

    def _move(self, page: _PageCamera, look_at: FloatArray, offset: FloatArray) -> None:
        page.offset, page.set_at = offset, monotonic()
        if page.ours and np.array_equal(page.ours[-1][1], offset):
            page.ours.pop()
        page.ours.append((look_at, offset))
        with page.client.atomic():
            camera = page.client.camera
            for _ in range(TRIES):
                camera.position = look_at + offset
                camera.look_at = look_at
                if np.allclose(camera.position, look_at + offset):  # else a pose from the page came in between
                    break
            if abs(camera.fov - FOV) > 1e-6:
                camera.fov = FOV

    def _centre(self, target: int) -> FloatArray:
        poses = self._poses
        if 0 < target <= len(poses):
            return np.append(poses[target - 1, :2], 0.0)
        return np.append(poses[:, :2].mean(axis=0), 0.0)

    def _follow_height(self) -> float:
        if self._scenario is None:
            return 0.75
        return 0.55 + 2.2 * float(np.hypot(*self._scenario.formation.array.T).max())

    @staticmethod
    def _wide(scenario: Scenario) -> bool:
        low, high = _bounds(scenario)
        return scenario.driven or bool((high - low).max() > WIDE_METRES)

    # ------------------------------------------------------------------ pages come and go

    def _connected(self, client: viser.ClientHandle) -> None:
        with self._lock:
            page = self._pages[client.client_id] = _PageCamera(client)
            home = self._server.initial_camera
            for camera in (client.camera, home):
                page.ours.append((np.array(camera.look_at), np.array(camera.position) - np.array(camera.look_at)))
            self._first(page)

        @client.camera.on_update
        def _(camera: viser.CameraHandle) -> None:
            with self._lock:
                position, look_at = _pose(camera)
                _note_user(page, look_at, position - look_at)

    def _gone(self, client: viser.ClientHandle) -> None:
        with self._lock:
            self._pages.pop(client.client_id, None)


def _pose(camera: Any) -> tuple[FloatArray, FloatArray]:
    """Position, and point looked at, both of one message of the page: another may come in between [m]."""
    for _ in range(TRIES):
        position, look_at = np.array(camera.position), np.array(camera.look_at)
        if np.array_equal(position, camera.position):
            break
    return position, look_at


def _note_user(page: _PageCamera, look_at: FloatArray, offset: FloatArray) -> None:
    """Take over a pose from a page. If the user moved the camera, cancel late fits, and follow with the new offset."""
    near = 0.01 * float(np.linalg.norm(page.offset))
    if page.target is None:
        if not any(np.linalg.norm(look_at - at) + np.linalg.norm(offset - to) < 2.0 * near for at, to in page.ours):
            page.fit_at = []
    elif all(np.linalg.norm(offset - to) > near for _, to in page.ours) and monotonic() - page.set_at < 10.0:
        page.offset = offset
        page.rest_until = monotonic() + HOLD_SECONDS


def _bounds(scenario: Scenario) -> tuple[FloatArray, FloatArray]:
    """Corners of the area that `fit` shows [m]."""
    line = path_points(scenario)
    reach = float(np.hypot(*scenario.formation.array.T).max()) + 0.08
    return line.min(axis=0) - reach, line.max(axis=0) + reach
