"""The cameras of all pages: fit, 3D, follow the formation or one robot. Each page has its own.

The camera is in perspective with a narrow angle: from above it looks flat, and it can be tilted into 3D. Every page
begins by following the formation; what a user then does to the camera is kept.
"""

import math
import threading
from collections import deque
from collections.abc import Sequence
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
MARGIN = 1.12
FOLLOWED = 3.5
"""Height of the view that follows the formation, in diameters of the formation."""
APART = 2.6
"""The same while the robots are apart, in diameters of what they spread over."""
LOWER = 0.035
"""The view's middle is lower than the formation by this share of its height: the time line hides nothing."""
BODY = 0.36
"""Width of a body by the spacing."""
OFF, NEAR = 0.15, 0.01
"""The zoom eases once it is off by this share, until it is as near as that."""
EASE_SECONDS = 0.3
"""Time constant of the zoom [s]."""
HOLD_SECONDS = 0.4
"""A following camera rests so long after a user moved it, then follows with the new offset [s]."""
TRIES = 4
"""To read or write a camera while its page sends another pose."""
STEP = 1e-3
"""A camera that follows moves once it is off by this share of its view's height: by less than a pixel or about one."""
ROUNDING = 1e-6
"""Relative to a place's coordinates."""
ABOVE: FloatArray = np.array([0.0, -TILT, 1.0])
"""Direction from the point looked at to a camera above it."""


@dataclass(slots=True)
class _PageCamera:
    """The camera of one page."""

    client: viser.ClientHandle
    target: int | None = None
    """Robot that is followed, 0 for the formation; None if nothing is."""
    offset: FloatArray = field(default_factory=lambda: np.array([0.0, 0.0, 1.0]))
    """From the point that the camera looks at to the camera [m]."""
    height: float | None = None
    """Of the view of a camera whose zoom follows the formation [m]; None once the user has chosen the zoom."""
    lower: float = 0.0
    """By so much the point looked at is below the formation's middle [m]."""
    easing: bool = False
    eased_at: float = 0.0
    set_at: float = 0.0
    rest_until: float = 0.0
    fit_at: list[float] = field(default_factory=list)
    """When to fit again: the page sends its size late [s]."""
    ours: deque[tuple[FloatArray, FloatArray]] = field(default_factory=lambda: deque(maxlen=40))
    """Points looked at and offsets last sent to the page: one that differs comes from the user [m]."""
    first: list[tuple[FloatArray, FloatArray]] = field(default_factory=list)
    """The same of the poses that the page may have before it has heard of any; a slow page sends one late."""


class Cameras:
    """Moves the cameras of all pages."""

    def __init__(self, server: viser.ViserServer) -> None:
        self._server = server
        self._lock = threading.RLock()
        self._pages: dict[int, _PageCamera] = {}
        self._scenario: Scenario | None = None
        self._diameter = 0.2
        """Of the formation as it should be, with the bodies [m]."""
        self._points: FloatArray = np.zeros((1, 2))
        """Where the robots are [m]."""
        self._middle, self._spread = np.zeros(2), 0.0
        """Of those that have an agent; of all, if none has [m]."""
        self._set_home(np.zeros(3), 3.0)
        server.on_client_connect(self._connected)
        server.on_client_disconnect(self._gone)

    def _set_home(self, centre: FloatArray, height: float) -> None:
        camera = self._server.initial_camera
        distance = _distance(height)
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
                page.fit_at = [monotonic() + pause for pause in (0.0, 0.7, 2.0)]

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
            page.height = None

    def follow(self, client: viser.ClientHandle, target: int = 0) -> None:
        """Keep a robot, or the formation (0), in the middle."""
        with self._lock:
            page = self._pages.get(client.client_id)
            if page is not None:
                self._follow(page, target)

    def _follow(self, page: _PageCamera, target: int) -> None:
        page.target, page.fit_at, page.easing, page.eased_at = target, [], False, monotonic()
        page.height = self._follow_height(page)
        self._move(page, self._looked_at(page), _distance(page.height) * ABOVE)

    def release(self, client: viser.ClientHandle) -> None:
        """Follow nothing."""
        with self._lock:
            page = self._pages.get(client.client_id)
            if page is not None:
                page.target = None

    # ------------------------------------------------------------------ every frame

    def update(self, scenario: Scenario, poses: FloatArray, live: Sequence[int]) -> None:
        """Move the cameras that follow; those robots that have an agent are the formation."""
        with self._lock:
            self._points = poses[:, :2]
            rows = [robot - 1 for robot in live if robot <= len(poses)]
            playing = self._points[rows] if rows and len(rows) < len(poses) else self._points
            low, high = playing.min(axis=0), playing.max(axis=0)
            self._middle, self._spread = (low + high) / 2.0, math.hypot(*(high - low).tolist())
            if scenario is not self._scenario:
                known, self._scenario = self._scenario, scenario
                self._diameter = _diameter(scenario)
                if known is None or known.path != scenario.path or known.size != scenario.size:
                    self._begin()
            now = monotonic()
            for page in self._pages.values():
                if page.fit_at and now >= page.fit_at[0]:
                    page.fit_at.pop(0)
                    self._fit(page, scenario)
                elif page.target is not None and now >= page.rest_until:
                    self._ease(page, now)
                    look_at = self._looked_at(page)
                    if not _is_there(page, look_at):
                        self._move(page, look_at, page.offset)

    def _begin(self) -> None:
        self._set_home(np.append(self._centre(0), 0.0), FOLLOWED * self._diameter)
        for page in self._pages.values():
            self._follow(page, 0)

    def _ease(self, page: _PageCamera, now: float) -> None:
        """Bring the zoom of a page nearer to the formation's size, if it is far off."""
        passed, page.eased_at = now - page.eased_at, now
        if page.height is None:
            return
        target = self._follow_height(page)
        off = abs(math.log(target / page.height))
        page.easing = off > (NEAR if page.easing else OFF)
        if page.easing:
            page.height *= (target / page.height) ** (1.0 - math.exp(-min(passed, 1.0) / EASE_SECONDS))
            page.offset = _distance(page.height) * ABOVE

    def _fit(self, page: _PageCamera, scenario: Scenario) -> None:
        if scenario.driven:  # there is no path to be shown before it is driven
            self._follow(page, 0)
            return
        low, high = _bounds(scenario)
        aspect = page.client.camera.aspect
        width, height = high - low
        distance = _distance(MARGIN * max(height, width / aspect))
        self._move(page, np.append((low + high) / 2.0, 0.0), distance * ABOVE)

    def _move(self, page: _PageCamera, look_at: FloatArray, offset: FloatArray) -> None:
        page.offset, page.set_at = offset, monotonic()
        if page.ours and np.array_equal(page.ours[-1][1], offset):
            page.ours.pop()
        page.ours.append((look_at, offset))
        with page.client.atomic():
            camera = page.client.camera
            for _ in range(TRIES):
                camera.position = look_at + offset  # viser moves the point looked at along with it
                if not _near(camera.look_at, look_at):
                    camera.look_at = look_at
                if _near(camera.position, look_at + offset):  # else a pose from the page came in between
                    break
            if abs(camera.fov - FOV) > 1e-6:
                camera.fov = FOV

    def _looked_at(self, page: _PageCamera) -> FloatArray:
        """(3,) the point in the middle of the view of a page that follows something [m]."""
        if page.height is not None:
            page.lower = 0.0 if page.target else LOWER * page.height
        x, y = self._centre(page.target or 0)
        return np.array([x, y - page.lower, 0.0])

    def _centre(self, target: int) -> FloatArray:
        """(2,) of a robot, or of the robots that have an agent (0) [m]."""
        if 0 < target <= len(self._points):
            return np.asarray(self._points[target - 1])
        return self._middle

    def _follow_height(self, page: _PageCamera) -> float:
        """Of the view of a page that follows the formation or a robot [m]."""
        height = max(FOLLOWED * self._diameter, APART * self._spread if not page.target else 0.0)
        return height / min(1.0, page.client.camera.aspect)

    # ------------------------------------------------------------------ pages come and go

    def _connected(self, client: viser.ClientHandle) -> None:
        with self._lock:
            page = self._pages[client.client_id] = _PageCamera(client)
            home = self._server.initial_camera
            for camera in (client.camera, home):
                page.first.append((np.array(camera.look_at), np.array(camera.position) - np.array(camera.look_at)))
            if self._scenario is not None:
                self._follow(page, 0)

        @client.camera.on_update
        def _(camera: viser.CameraHandle) -> None:
            with self._lock:
                position, look_at = _pose(camera)
                _note_user(page, look_at, position - look_at)

    def _gone(self, client: viser.ClientHandle) -> None:
        with self._lock:
            self._pages.pop(client.client_id, None)


def _diameter(scenario: Scenario) -> float:
    """Of the formation as it should be, with the bodies [m]."""
    reach = float(np.hypot(*scenario.formation.array.T).max())
    return 2.0 * reach + BODY * float(scenario.pattern.distance.min())


def _distance(height: float) -> float:
    """From which a view is so high [m]."""
    return 0.5 * height / math.tan(FOV / 2.0)


def _near(place: FloatArray, wanted: FloatArray) -> bool:
    """Whether two places are the same but for rounding [m]."""
    return bool(np.abs(place - wanted).max() <= ROUNDING * (1.0 + np.abs(wanted).max()))


def _is_there(page: _PageCamera, look_at: FloatArray) -> bool:
    """Whether a camera is where it should be, as far as is seen: each move costs as much as drawing all bodies."""
    position, seen = _pose(page.client.camera)
    off = max(np.abs(seen - look_at).max(), np.abs(position - look_at - page.offset).max())
    return bool(off < STEP * 2.0 * math.tan(FOV / 2.0) * np.abs(page.offset).max())


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
    ours = [*page.first, *page.ours]
    if page.target is None:
        if not any(np.linalg.norm(look_at - at) + np.linalg.norm(offset - to) < 2.0 * near for at, to in ours):
            page.fit_at = []
    elif all(np.linalg.norm(offset - to) > near for _, to in ours) and monotonic() - page.set_at < 10.0:
        page.offset, page.height = offset, None
        page.rest_until = monotonic() + HOLD_SECONDS


def _bounds(scenario: Scenario) -> tuple[FloatArray, FloatArray]:
    """Corners of the area that `fit` shows [m]."""
    line = path_points(scenario)
    reach = float(np.hypot(*scenario.formation.array.T).max()) + 0.08
    return line.min(axis=0) - reach, line.max(axis=0) + reach
