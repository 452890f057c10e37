"""The overlay of every page: hidden elements that hold what it shows, and the script that shows it.

A panel cannot stand over the scene, and its HTML would be cut off, replaced while it is dragged, or folded away. So the
script (overlay.js) makes elements of its own over the canvas and fills them with what it finds in the hidden ones.
"""

import json
from collections.abc import Callable
from html import escape
from importlib.resources import files
from typing import Any

import viser

from dashboard.edits import Edit, on_edit
from dashboard.keys import CELLS, COMMANDS, HANDLE, HELP, driving_keys
from dashboard.notices import Notice
from dashboard.overlay.chips import chips
from dashboard.overlay.help import help_html
from dashboard.overlay.status_line import status_line
from dashboard.panels.mirrored_controls import set_if_changed
from dashboard.scene.layers import Sizes
from dashboard.telemetry.feed import View
from dashboard.telemetry.snapshot import Snapshot
from dashboard.theme.signs import SIGNS
from dashboard.theme.templates import render

SCRIPTS = ("overlay", "time_line", "help", "reach", "drive")
MAX_TEXT = 64
"""Of what a page writes into the hidden field."""

OnWritten = Callable[[int, list[str]], None]
"""(page, words): what the script of a page tells, such as ["width", "1280"]."""


class Overlay:
    """The hidden elements, in the current container of the page."""

    def __init__(self, server: viser.ViserServer, on_written: OnWritten) -> None:
        """Add the elements and the script.

        Args:
            server: of the page.
            on_written: a page's script told something.
        """
        self._server, self._on_written = server, on_written
        gui = server.gui
        self._text: Any = gui.add_text("Overlay", "")
        on_edit(self._text, self._written)
        label = f"label[for='{self._text._impl.uuid}']"
        script = "\n".join(_script(name) for name in SCRIPTS).replace("LABEL", label)
        script = script.replace('"TABLES"', json.dumps(_tables()))
        self._config = gui.add_html("")
        self._status = gui.add_html("")
        self._chips = gui.add_html("")
        self._drive = gui.add_html("")
        gui.add_html(
            f"<style>:has(> * > * > * > {label}){{display:none}}</style>"
            f'<img alt="" style="display:none" src="data:," onerror="{escape(script)}">'
        )
        self._notices: dict[int, Any] = {}
        self._count = 0
        server.on_client_disconnect(self._closed)

    def _closed(self, client: viser.ClientHandle) -> None:
        self._notices.pop(client.client_id, None)

    def _written(self, edit: Edit) -> None:
        if len(edit.value) <= MAX_TEXT:
            self._on_written(edit.page, edit.value.split(",")[:-1])  # behind the last comma: what makes it differ

    def notify(self, page: int | None, notice: Notice) -> None:
        """Show a notice for a while in the status line of one page, or of all."""
        self._count += 1
        content = render("overlay/notice_line.html", notice=notice, number=self._count)
        for number, client in self._server.get_clients().items():
            if page is None or page == number:
                if number not in self._notices:
                    self._notices[number] = client.gui.add_html("")
                self._notices[number].content = content

    def draw(self, view: View, sizes: Sizes) -> None:
        """Show the status line and the chips of a moment."""
        config = {"length": sizes.body[0], "digit": 0.024 * sizes.unit}
        set_if_changed(self._config, "content", hidden_part("config", config))
        set_if_changed(self._drive, "content", hidden_part("drive", _driving(view.snapshot)))
        line = status_line(view.snapshot, view.links)
        set_if_changed(self._status, "content", render("overlay/status_line.html", line=line))
        shown = render("overlay/chips.html", chips=chips(view.snapshot, view.beliefs))
        set_if_changed(self._chips, "content", shown)


def _driving(snapshot: Snapshot) -> dict[str, float] | None:
    """What is ordered, and at most can be, if the path is driven."""
    state, scenario = snapshot.state, snapshot.scenario
    if state is None or scenario is None or not scenario.driven:
        return None
    ordered, law = state.driving, scenario.law
    return {"v": round(ordered.v, 3), "omega": round(ordered.omega, 3), "speed": law.speed, "turn": law.turn}


def hidden_part(name: str, value: object) -> str:
    """A hidden element that holds a value for the script."""
    return f'<div hidden class="e-source" data-part="{name}" data-value="{escape(json.dumps(value))}"></div>'


def _tables() -> dict[str, object]:
    """What the scripts have in common with this program: signs, keys, and the help about both."""
    return {
        "signs": {kind: (sign.form, sign.colour) for kind, sign in SIGNS.items()},
        "shortcuts": {name: key for name, (key, _) in COMMANDS.items()},
        "handle": {key: one.words for key, one in HANDLE.items()},
        "cells": {key: one.step for key, one in CELLS.items()},
        "driving": driving_keys(),
        "helpKey": HELP,
        "help": help_html(),
    }


def _script(name: str) -> str:
    return files("dashboard").joinpath(f"overlay/{name}.js").read_text(encoding="utf-8")
