"""Cells of a table that can be clicked.

viser has no table, and its HTML sends no events. A click on a cell therefore clicks a hidden button of viser's: it
then arrives over the web socket as any other, with the page it came from. With the keyboard, overlay/reach.js does.
"""

from collections.abc import Callable
from typing import Any

import viser

from dashboard.edits import Edit, on_edit

NOTHING = "nothing"
NAMES = {
    "all": "Aim faults at all links",
    "driver": "Aim faults at the driver's link",
    "link": "Aim faults at the link from robot {}",
    "both": "Aim faults at both links of robot {}",
    "focus": "Follow robot {}",
    "leave": "Let robot {} leave the ring",
    "join": "Let robot {} join the ring",
    "excursion": "Go to this excursion",
}
"""What a cell of a verb is called for those who do not see the table; other verbs stand before the robot's number."""

OnClick = Callable[[str, int, viser.ClientHandle], None]
"""(verb, number, page): what was clicked, and where."""


class Clickable:
    """The hidden buttons, one for each (verb, number)."""

    def __init__(self, gui: viser.GuiApi, on_click: OnClick) -> None:
        """Add the buttons to the current container of the page, where they take no room."""
        self._on_click = on_click
        self._indices: dict[str, int] = {}
        self._group: Any = gui.add_button_group(NOTHING, (NOTHING,))
        label = f"label[for='{self._group._impl.uuid}']"
        gui.add_html(f"<style>:has(> * > * > * > {label}){{display:none}}</style>")
        self.script = (
            "var c=event.target.closest('[data-click]');"
            f'if(c)document.querySelector("{label}").closest(":has(button)")'
            ".querySelectorAll('button')[c.dataset.click].click()"
        )
        """For `onpointerdown` of the element around the cells; a table may be replaced before the release."""
        on_edit(self._group, self._clicked)

    def set_verbs(self, verbs: dict[str, int]) -> None:
        """Take clicks of these verbs, each with numbers from 0 up to this one."""
        options = tuple(f"{verb} {number}" for verb, top in verbs.items() for number in range(top + 1)) or (NOTHING,)
        if self._group.options != options:
            self._group.options = options
            self._indices = {name: index for index, name in enumerate(options)}

    def attributes(self, verb: str, number: int) -> dict[str, str]:
        """HTML attributes of a cell that can be clicked, for Jinja's xmlattr; none before the verb is set."""
        name = f"{verb} {number}"
        if name not in self._indices:
            return {}
        words = NAMES.get(verb, f"{verb.capitalize()} agent {{}}").format(number)
        index = str(self._indices[name])
        return {"data-click": index, "data-cell": name, "role": "button", "tabindex": "0", "aria-label": words}

    def _clicked(self, edit: Edit) -> None:
        verb, _, number = edit.value.partition(" ")
        if number:
            self._on_click(verb, int(number), edit.client)
