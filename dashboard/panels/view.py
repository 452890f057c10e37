"""The view folder: camera, theme, the robot that is followed, and the scene's layers."""

from collections.abc import Callable
from functools import partial
from typing import Any

import viser

from dashboard.edits import Edit, on_edit, set_value
from dashboard.keys import bind
from dashboard.panels.mirrored_controls import set_options
from dashboard.scene.cameras import Cameras
from dashboard.scene.scene import LAYERS, Scene
from dashboard.theme.palette import DARK, LIGHT, Palette
from dashboard.theme.templates import render
from network.messages import State

NOBODY = "none"
CAMERA = ("Fit", "3D", "Follow")
"""The camera's buttons; each is a command with a key too."""


class ViewPanel:
    """Controls of what is drawn and from where, in the current container of the page."""

    def __init__(
        self, gui: viser.GuiApi, cameras: Cameras, scene: Scene, on_palette: Callable[[Palette], None]
    ) -> None:
        """Add the folder.

        Args:
            gui: of the page.
            cameras: of all pages.
            scene: whose layers and chosen robot are set.
            on_palette: a user chose this theme, for all pages.
        """
        self._cameras, self._scene = cameras, scene
        with gui.add_folder("View"):
            camera = gui.add_button_group("Camera", CAMERA)
            light = gui.add_checkbox("Light", False, hint="Light instead of dark, on every page of this run")
            self._focus: Any = gui.add_dropdown("Follow robot", (NOBODY,), initial_value=NOBODY)
            gui.add_html(render("panels/legend.html"))
            with gui.add_folder("Layers", expand_by_default=False):
                for name in LAYERS:
                    box = gui.add_checkbox(name, True)
                    on_edit(box, partial(self._show_layer, name))
        on_edit(light, lambda edit: on_palette(LIGHT if edit.value else DARK))
        on_edit(camera, lambda edit: self._move_camera(edit.value, edit))
        on_edit(self._focus, self._focus_chosen)
        for name in CAMERA:
            bind(gui, f"View: {name}", viser.Icon.CAMERA, partial(self._move_camera, name))

    def draw(self, state: State) -> None:
        """Offer the robots of this state."""
        set_options(self._focus, (NOBODY, *(f"Robot {i}" for i in range(1, len(state.poses) + 1))))

    def focus_on(self, client: viser.ClientHandle, robot: int) -> None:
        """Outline a robot on all pages, and follow it on this one."""
        name = f"Robot {robot}"
        if name in self._focus.options:
            self._scene.focus = robot
            set_value(self._focus, name)
            self._cameras.follow(client, robot)

    def _focus_chosen(self, edit: Edit) -> None:
        name = edit.value
        if name not in self._focus.options:  # the ring may just have become another
            return
        self._scene.focus = None if name == NOBODY else int(name.split()[-1])
        if self._scene.focus is None:
            self._cameras.release(edit.client)
        else:
            self._cameras.follow(edit.client, self._scene.focus)

    def _show_layer(self, name: str, edit: Edit) -> None:
        self._scene.show_layer(name, bool(edit.value))

    def _move_camera(self, button: str, event: Any) -> None:
        if event.client is None:
            return
        if button == "3D":
            self._cameras.tilt(event.client)
        elif button == "Follow":
            self._cameras.follow(event.client)
        else:
            self._cameras.fit(event.client)
            self._scene.focus = None
            set_value(self._focus, NOBODY)
