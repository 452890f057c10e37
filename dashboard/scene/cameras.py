"""Where each person looks from: fit, 3D, follow the formation or one robot. Each page has its own view.

The camera is in perspective with a narrow angle, which looks flat from above and tips into 3D when it is dragged.
"""

import math
import threading
from collections import deque
from dataclasses import dataclass, field
from time import monotonic
from typing import Any

import numpy as np
import viser

from dashboard.scene.scene import route_line
from formation.arrays import FloatArray
from formation.scenario.scenario import Scenario

FOV = math.radians(12.0)
TILT = 0.004
"""Straight down would leave open which way is up."""
WIDE_METRES = 4.0
"""On longer paths the robots would be dots: then the view follows them from the start."""
MARGIN = 1.12
HANDS_OFF_SECONDS = 0.4
"""A following view rests so long after a person moved it, then goes on from there."""
TRIES = 4
"""To agree with a page that speaks at the same moment."""
ASPECT = 1.1
"""Width by height of the free part of the page, until the page has said."""


@dataclass(slots=True)
class _View:
    """One page's view."""

    client: viser.ClientHandle
    target: int | None = None
    """Robot that is followed, 0 for the formation; None if nothing is."""
    offset: FloatArray = field(default_factory=lambda: np.array([0.0, 0.0, 1.0]))
    """From the point that is looked at to the camera [m]."""
    set_at: float = 0.0
    rest_until: float = 0.0
    fit_at: list[float] = field(default_factory=list)
    """When to fit again: the page tells its size late."""
    ours: deque[tuple[FloatArray, FloatArray]] = field(default_factory=lambda: deque(maxlen=6))
    """What this page was last told to look at, and from where: what differs is a person's doing [m]."""


class Cameras:
    """Moves the cameras of all pages."""

    def __init__(self, server: viser.ViserServer) -> None:
        self._server = server
        self._lock = threading.RLock()
        self._views: dict[int, _View] = {}
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

    # ------------------------------------------------------------------ what people ask

    def fit(self, client: viser.ClientHandle) -> None:
        """Show the whole path from above."""
        with self._lock:
            view = self._views.get(client.client_id)
            if view is not None:
                view.target = None
                view.fit_at = [monotonic(), monotonic() + 0.4]

    def tip(self, client: viser.ClientHandle) -> None:
        """Look at the same thing from the side."""
        with self._lock:
            view = self._views.get(client.client_id)
            if view is None:
                return
            view.fit_at = []
            look_at = np.array(client.camera.look_at)
            distance = float(np.linalg.norm(np.array(client.camera.position) - look_at))
            self._move(view, look_at, 0.92 * distance * np.array([-0.30, -0.66, 0.69]))

    def follow(self, client: viser.ClientHandle, target: int = 0) -> None:
        """Keep a robot, or the formation (0), in the middle."""
        with self._lock:
            view = self._views.get(client.client_id)
            if view is not None:
                self._follow(view, target)

    def _follow(self, view: _View, target: int) -> None:
        view.target = target
        view.fit_at = []
        distance = 0.5 * self._follow_height() / math.tan(FOV / 2.0)
        self._move(view, self._centre(target), distance * np.array([0.0, -TILT, 1.0]))

    def release(self, client: viser.ClientHandle) -> None:
        """Follow nothing."""
        with self._lock:
            view = self._views.get(client.client_id)
            if view is not None:
                view.target = None

    # ------------------------------------------------------------------ every frame

    def update(self, scenario: Scenario, poses: FloatArray) -> None:
        """Move the views that follow."""
        with self._lock:
            self._poses = poses
            if scenario is not self._scenario:
                known, self._scenario = self._scenario, scenario
                if known is None or known.path != scenario.path or known.size != scenario.size:
                    self._begin(scenario)
            now = monotonic()
            for view in self._views.values():
                if view.fit_at and now >= view.fit_at[0]:
                    view.fit_at.pop(0)
                    self._fit(view, scenario)
                elif view.target is not None and now >= view.rest_until:
                    self._move(view, self._centre(view.target), view.offset)

    def _begin(self, scenario: Scenario) -> None:
        low, high = _bounds(scenario)
        width, height = high - low
        if self._wide(scenario):
            self._set_home(self._centre(0), self._follow_height())
        else:
            self._set_home((low + high) / 2.0, max(height, width / ASPECT))
        for view in self._views.values():
            self._first(view)

    def _first(self, view: _View) -> None:
        if self._scenario is not None and self._wide(self._scenario):
            self._follow(view, 0)
        else:
            view.target = None
            view.fit_at = [monotonic() + pause for pause in (0.0, 0.7, 2.0)]

    def _fit(self, view: _View, scenario: Scenario) -> None:
        low, high = _bounds(scenario)
        aspect = view.client.camera.aspect
        width, height = high - low
        distance = 0.5 * MARGIN * max(height, width / aspect) / math.tan(FOV / 2.0)
        self._move(view, np.append((low + high) / 2.0, 0.0), distance * np.array([0.0, -TILT, 1.0]))

    def _move(self, view: _View, look_at: FloatArray, offset: FloatArray) -> None:
        view.offset, view.set_at = offset, monotonic()
        if view.ours and np.array_equal(view.ours[-1][1], offset):
            view.ours.pop()
        view.ours.append((look_at, offset))
        with view.client.atomic():
            camera = view.client.camera
            for _ in range(TRIES):
                camera.position = look_at + offset
                camera.look_at = look_at
                if np.allclose(camera.position, look_at + offset):  # else the page's own word came in between
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
        return bool((high - low).max() > WIDE_METRES)

    # ------------------------------------------------------------------ pages come and go

    def _connected(self, client: viser.ClientHandle) -> None:
        with self._lock:
            view = self._views[client.client_id] = _View(client)
            home = self._server.initial_camera
            for camera in (client.camera, home):
                view.ours.append((np.array(camera.look_at), np.array(camera.position) - np.array(camera.look_at)))
            self._first(view)

        @client.camera.on_update
        def _(camera: viser.CameraHandle) -> None:
            with self._lock:
                position, look_at = _pose(camera)
                _note_hand(view, look_at, position - look_at)

    def _gone(self, client: viser.ClientHandle) -> None:
        with self._lock:
            self._views.pop(client.client_id, None)


def _pose(camera: Any) -> tuple[FloatArray, FloatArray]:
    """Position and point that is looked at, both of the same word of the page's: another may come in between [m]."""
    for _ in range(TRIES):
        position, look_at = np.array(camera.position), np.array(camera.look_at)
        if np.array_equal(position, camera.position):
            break
    return position, look_at


def _note_hand(view: _View, look_at: FloatArray, offset: FloatArray) -> None:
    """A page says how it looks. If a person moved it, late fits are off, and what follows goes on from there."""
    near = 0.01 * float(np.linalg.norm(view.offset))
    if view.target is None:
        if not any(np.linalg.norm(look_at - at) + np.linalg.norm(offset - to) < 2.0 * near for at, to in view.ours):
            view.fit_at = []
    elif all(np.linalg.norm(offset - to) > near for _, to in view.ours) and monotonic() - view.set_at < 10.0:
        view.offset = offset
        view.rest_until = monotonic() + HANDS_OFF_SECONDS


def _bounds(scenario: Scenario) -> tuple[FloatArray, FloatArray]:
    """Corners of what a fitting view shows [m]."""
    line = route_line(scenario)
    reach = float(np.hypot(*scenario.formation.array.T).max()) + 0.08
    return line.min(axis=0) - reach, line.max(axis=0) + reach
