"""The keys of one page that drive: a script that writes what is held into a hidden text field of viser's.

viser knows presses of keys, but no releases. The script listens before viser does, so that the camera and the shortcuts
do not get these keys; it says what is held ten times a second, and nothing once everything is released.
"""

import json
import math
from collections.abc import Callable
from html import escape
from importlib.resources import files
from typing import Any

import viser

from dashboard.edits import Edit, on_edit
from dashboard.keys import DRIVING

OnHeld = Callable[[int, float, float], None]
"""(page, v, omega): shares in -1 to 1 that the held keys ask for."""


class Wheel:
    """The wheel in the hands of one page."""

    def __init__(self, client: viser.ClientHandle, on_held: OnHeld) -> None:
        """Give the page the wheel.

        Args:
            client: the page.
            on_held: keys are held, or were released.
        """
        self.page = client.client_id
        self._on_held = on_held
        self._text: Any = client.gui.add_text("Held keys", "")
        label = f"label[for='{self._text._impl.uuid}']"
        script = files("dashboard").joinpath("steering/wheel.js").read_text(encoding="utf-8").replace("LABEL", label)
        script = script.replace('"WAYS"', json.dumps({code: key.signs for code, key in DRIVING.items()}))
        self._html = client.gui.add_html(
            f"<style>:has(> * > * > * > {label}){{display:none}}</style>"
            f'<img alt="" style="display:none" src="data:," onerror="{escape(script)}">'
        )
        on_edit(self._text, self._written)

    def remove(self) -> None:
        """Take it back; the script notices that its field is gone."""
        self._html.remove()
        self._text.remove()

    def _written(self, edit: Edit) -> None:
        held = parse(edit.value)
        if edit.page == self.page and held is not None:
            self._on_held(self.page, *held)


def parse(text: object) -> tuple[float, float] | None:
    """v and omega of "v,omega,stamp", each within -1 and 1; None if it is anything else."""
    if not isinstance(text, str) or len(text) > 64:
        return None
    parts = text.split(",")
    try:
        v, omega, _ = (float(part) for part in parts)
    except ValueError:
        return None
    if not (math.isfinite(v) and math.isfinite(omega)):
        return None
    return min(max(v, -1.0), 1.0), min(max(omega, -1.0), 1.0)
