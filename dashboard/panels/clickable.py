"""Cells of a table that can be pressed.

viser has no table, and its HTML tells of no events. A cell therefore presses a button of viser's that is not shown:
the press then comes over the web socket like any other, with the page it came from.
"""

from collections.abc import Callable
from typing import Any

import viser

NOTHING = "nothing"

OnTap = Callable[[str, int, viser.GuiEvent[Any]], None]
"""(verb, number, event): what was pressed."""


class Clickable:
    """The hidden buttons, one for each (verb, number)."""

    def __init__(self, gui: viser.GuiApi, on_tap: OnTap) -> None:
        """Stand in the current container of the page, without taking room there."""
        self._on_tap = on_tap
        self._places: dict[str, int] = {}
        self._group: Any = gui.add_button_group(NOTHING, (NOTHING,))
        label = f"label[for='{self._group._impl.uuid}']"
        gui.add_html(f"<style>:has(> * > * > * > {label}){{display:none}}</style>")
        self._script = (
            "var c=event.target.closest('[data-tap]');"
            f"if(c)document.querySelector(&quot;{label}&quot;).closest(&quot;:has(button)&quot;)"
            ".querySelectorAll('button')[c.dataset.tap].click()"
        )
        self._group.on_click(self._pressed)

    def set_options(self, verbs: dict[str, int]) -> None:
        """Take presses of these verbs, each with numbers from 0 up to this one."""
        options = tuple(f"{verb} {number}" for verb, top in verbs.items() for number in range(top + 1)) or (NOTHING,)
        if self._group.options != options:
            self._group.options = options
            self._places = {name: place for place, name in enumerate(options)}

    def around(self, content: str) -> str:
        """HTML in which elements with `tap` can be pressed. At once, not on release: tables are replaced meanwhile."""
        return f'<div onpointerdown="{self._script}">{content}</div>'

    def tap(self, verb: str, number: int) -> str:
        """Attributes of an element that can be pressed."""
        name = f"{verb} {number}"
        if name not in self._places:
            return ""
        return f'data-tap="{self._places[name]}" role="button" aria-label="{name}"'

    def _pressed(self, event: viser.GuiEvent[Any]) -> None:
        if event.client is None or event.target.value not in self._group.options:  # a page may send anything
            return
        verb, _, number = event.target.value.partition(" ")
        if number:
            self._on_tap(verb, int(number), event)
