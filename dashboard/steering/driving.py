"""The drive folder: keys, buttons and clicks on the ground that drive a formation whose path is driven.

One page at a time has the wheel. Its keys say ten times a second what is held; the world lets an order that is not said
again end, so that a page that is closed, or loses a key's release, stops the formation.
"""

import math
from typing import Any

import viser

from dashboard.edits import on_edit
from dashboard.panels.mirrored_controls import set_if_changed
from dashboard.requests import RequestQueue
from dashboard.steering.wheel import Wheel
from dashboard.telemetry.snapshot import Snapshot
from dashboard.theme.templates import render
from formation.scenario.scenario import Scenario
from network.control import Drive, GoTo

HELD_SECONDS = 0.3
"""An order of the keys ends after so long, unless it is said again [s]."""
PRESSED_SECONDS = 2.0
"""An order of a button [s]."""
BUTTONS = {"Left": (0, 1), "Ahead": (1, 0), "Back": (-1, 0), "Right": (0, -1), "Stop": (0, 0)}
"""Signs of v and omega."""
START_SHARE = 0.5
"""Of the highest speed and turn rate, before a user moves the sliders."""


class DrivePanel:
    """Controls that drive, in the current container of the page; hidden where the path is not driven."""

    def __init__(self, server: viser.ViserServer, requests: RequestQueue) -> None:
        self._server, self._requests = server, requests
        self._scenario: Scenario | None = None
        self._origin = (0.0, 0.0)
        """Of what is drawn, in the scenario's coordinates [m]."""
        gui = server.gui
        self._folder = gui.add_folder("Drive", visible=False)
        with self._folder:
            self._shown = gui.add_html("")
            self._take = gui.add_button("Take the wheel", hint="Then W A S D or the arrow keys drive, on this page")
            self._buttons = gui.add_button_group("Drive", tuple(BUTTONS))
            self._speed: Any = gui.add_slider("Speed %", 5, 100, 5, 100 * START_SHARE)
            self._turn: Any = gui.add_slider("Turn %", 5, 100, 5, 100 * START_SHARE)
            self._click = gui.add_checkbox(
                "Click on the ground: go there", False, hint="On the page that has the wheel; the centre stops there"
            )
        self._wheel: Wheel | None = None
        on_edit(self._take, lambda edit: self._toggle(edit.client))
        on_edit(self._buttons, lambda edit: self._press(edit.value, edit.page))
        server.on_client_disconnect(self._gone)

    # ------------------------------------------------------------------ the wheel

    def _toggle(self, client: viser.ClientHandle) -> None:
        """The page takes the wheel, from another if need be, or gives it back."""
        if self._scenario is None:
            return
        mine = self._wheel is not None and self._wheel.page == client.client_id
        self._release()
        if not mine:
            self._wheel = Wheel(client, self._held)

    def _release(self) -> None:
        wheel, self._wheel = self._wheel, None
        if wheel is not None:
            wheel.remove()

    def _gone(self, client: viser.ClientHandle) -> None:
        if self._wheel is not None and self._wheel.page == client.client_id:
            self._wheel = None

    # ------------------------------------------------------------------ from the user to the world

    def _order(self, v: float, omega: float, seconds: float) -> Drive | None:
        """Shares of the chosen speed and turn rate as an order."""
        scenario = self._scenario
        if scenario is None:
            return None
        speed, turn = (_share(slider.value) for slider in (self._speed, self._turn))
        return Drive(v=v * speed * scenario.law.speed, omega=omega * turn * scenario.law.turn, seconds=seconds)

    def _held(self, page: int, v: float, omega: float) -> None:
        """Keys are held on the page that has the wheel."""
        order = self._order(v, omega, HELD_SECONDS)
        if order is not None and self._wheel is not None and self._wheel.page == page:
            self._requests.steer(order, page)

    def _press(self, name: str, page: int) -> None:
        if not self._taken_by_other(page):
            order = self._order(*BUTTONS[name], PRESSED_SECONDS)
            if order is not None:
                self._requests.steer(order, page)

    def wants(self, page: int) -> bool:
        """Whether clicks on the ground of this page are orders."""
        return self._wheel is not None and self._wheel.page == page and bool(self._click.value)

    def go(self, page: int, x: float, y: float) -> None:
        """A page clicked here: the formation goes there [m]."""
        east, north = self._origin
        self._requests.steer(GoTo(x=x + east, y=y + north), page)

    def _taken_by_other(self, page: int) -> bool:
        return self._wheel is not None and self._wheel.page != page

    # ------------------------------------------------------------------ from the world to the panel

    def draw(self, snapshot: Snapshot) -> None:
        """Show what is ordered, and how old each robot's knowledge of it is."""
        scenario, state = snapshot.scenario, snapshot.state
        driven = scenario if scenario is not None and scenario.driven else None
        self._scenario = driven
        set_if_changed(self._folder, "visible", driven is not None)
        if driven is None or state is None:
            self._release()
        if driven is None or state is None:
            return
        page = self._wheel.page if self._wheel else None
        set_if_changed(self._take, "label", "Take the wheel" if page is None else f"Page {page} has the wheel")
        east, north = self._origin = (float(snapshot.origin[0]), float(snapshot.origin[1]))
        goal = None if state.driving.goal is None else (state.driving.goal[0] + east, state.driving.goal[1] + north)
        shown = render("steering/driving.html", driving=state.driving, goal=goal, law=driven.law, page=page)
        set_if_changed(self._shown, "content", shown)


def _share(percent: object) -> float:
    """A slider's value as a share; a page may have sent anything."""
    if isinstance(percent, int | float) and math.isfinite(percent):
        return min(max(float(percent), 0.0), 100.0) / 100.0
    return START_SHARE
