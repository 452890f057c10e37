"""The push folder: disturb a robot's body, drag a robot aside, change shape and spacing while the run goes on."""

import math
from time import monotonic
from typing import Any

import numpy as np
import viser

from dashboard.edits import Edit, on_edit, set_value
from dashboard.panels.mirrored_controls import MirroredControl, set_if_changed, set_options
from dashboard.requests import RequestQueue
from dashboard.telemetry.snapshot import Snapshot
from dashboard.theme.templates import render
from formation.disturbances import FARTHEST, PUSHES, Kind
from formation.metrics import nearest
from formation.shapes import FIXED_SIZES, SHAPES
from network.interventions import Move, Push, Release, Reshape

FOR_SECONDS = 10.0
ROWS: tuple[tuple[Kind, ...], ...] = (("gust", "slow", "stuck"), ("slippery", "blind"))
"""Buttons, row by row: what fits into the narrow panel."""
PICK = "choose…"
SPACING = (40.0, 400.0, 5.0)
"""Of the slider: least, most, step [mm]."""
MANY, MANY_SECONDS = 100, 2.0
"""Of more robots the nearest two places are sought so seldom [s]: that takes the square of their number."""
DRAGGED = 0.01
"""A drag shorter than this moves nothing [m]: a click is not meant to."""


class PushPanel:
    """Controls that act on the robots, in the current container of the page."""

    def __init__(self, gui: viser.GuiApi, requests: RequestQueue) -> None:
        self._requests = requests
        self._robots = 1
        self._measured_at = 0.0
        self._drags: dict[int, Any] = {}
        """By page, the line from the robot to the pointer."""
        buttons = [[kind.capitalize() for kind in row] for row in ROWS]
        with gui.add_folder("Push", visible=requests.possible):
            self._robot: Any = gui.add_dropdown("Robot", ("Robot 1",))
            self._acting = gui.add_html("")
            self._timed = gui.add_checkbox(
                f"Push for {FOR_SECONDS:.0f} s", True, hint="Else until Release or a reset; simulated time"
            )
            for row in buttons:
                group = gui.add_button_group(" ", tuple(row), hint=_hint(row))
                on_edit(group, self._press)
            release = gui.add_button("Release", color="gray", hint="End all pushes of this robot")
            on_edit(release, lambda edit: self._requests.ask(Release(robot=self._number), edit.page))
            self._shape: Any = gui.add_dropdown("Shape", (PICK,), hint="Takes it from now on; a reset returns")
            self._spacing = MirroredControl(
                gui.add_slider("Spacing mm", *SPACING, 100.0, hint="Least distance of two places")
            )
        on_edit(self._shape, self._reshape)
        on_edit(self._spacing.control, self._respace)

    # ------------------------------------------------------------------ from the user to the world

    @property
    def _number(self) -> int:
        label = self._robot.value
        return self._robot.options.index(label) + 1 if label in self._robot.options else 1

    def choose(self, robot: int) -> None:
        """Choose the robot that buttons push."""
        if 1 <= robot <= self._robots:
            set_value(self._robot, _label(robot))

    def _press(self, edit: Edit) -> None:
        kind = next(kind for kind in PUSHES if kind == edit.value.lower())
        seconds = FOR_SECONDS if self._timed.value else None
        self._requests.ask(Push(robot=self._number, kind=kind, seconds=seconds), edit.page)

    def _reshape(self, edit: Edit) -> None:
        if edit.value in _shapes(self._robots):
            self._requests.ask(Reshape(shape=edit.value), edit.page)
            set_value(self._shape, PICK)

    def _respace(self, edit: Edit) -> None:
        self._requests.settle("spacing", Reshape(spacing=edit.value / 1000.0), edit.page)

    def dragged(self, robot: int, event: viser.SceneNodeDragEvent[Any]) -> None:
        """A user drags this robot: a line shows where to; it is carried there once it is let go."""
        client, page = event.client, event.client_id
        start, end = (_on_ground(event, place) for place in (event.start_position, event.end_position))
        line = self._drags.pop(page, None)
        if start is None or end is None or event.phase == "end":
            if line is not None:
                line.remove()
            if start is not None and end is not None:
                self._let_go(robot, end[0] - start[0], end[1] - start[1], page)
            return
        points = np.array([[[*start, 0.02], [*end, 0.02]]])
        if line is None:
            line = client.scene.add_line_segments("/drag", points, (255, 255, 255), thickness=2.5)
        else:
            line.points = points
        self._drags[page] = line

    def _let_go(self, robot: int, dx: float, dy: float, page: int) -> None:
        way = math.hypot(dx, dy)
        if way < DRAGGED or robot > self._robots:
            return
        if way > FARTHEST:
            self._requests.refuse("Not done", f"A robot is moved by at most {FARTHEST:g} m, not {way:.2f} m.", page)
            return
        self._requests.ask(Move(robot=robot, dx=dx, dy=dy), page)

    # ------------------------------------------------------------------ from the world to the panel

    def draw(self, snapshot: Snapshot) -> None:
        """Show what acts now, and the spacing."""
        state = snapshot.state
        if state is None:
            return
        self._robots = len(state.poses)
        set_options(self._robot, tuple(map(_label, range(1, self._robots + 1))))
        set_options(self._shape, (PICK, *_shapes(self._robots)))
        set_if_changed(self._acting, "content", render("panels/push.html", pushes=state.pushes, now=state.stamp))
        if monotonic() - self._measured_at >= (0.0 if self._robots <= MANY else MANY_SECONDS):
            self._measured_at = monotonic()
            apart = 1000.0 * float(nearest(state.slots[:, :2])[2])
            self._spacing.show(min(max(round(apart / SPACING[2]) * SPACING[2], SPACING[0]), SPACING[1]))


def _label(robot: int) -> str:
    return f"Robot {robot}"


def _hint(names: list[str]) -> str:
    return "; ".join(f"{name}: {PUSHES[kind].help}" for name in names for kind in PUSHES if kind == name.lower())


def _shapes(robots: int) -> tuple[str, ...]:
    """Shapes for so many robots."""
    return tuple(name for name in SHAPES if FIXED_SIZES.get(name, robots) == robots)


def _on_ground(event: viser.SceneNodeDragEvent[Any], place: tuple[float, float, float]) -> tuple[float, float] | None:
    """Where the ray from the camera through a place meets the ground [m]; None if it does not."""
    eye = np.asarray(event.client.camera.position, dtype=float)
    way = np.asarray(place, dtype=float) - eye
    if way.shape != (3,) or not way[2] < 0.0:
        return None
    found = eye - way * (eye[2] / way[2])
    x, y = float(found[0]), float(found[1])
    return (x, y) if math.isfinite(x) and math.isfinite(y) else None
