"""Controls that show what the world says, and yet can be moved by a person."""

from time import time
from typing import Any

HANDS_OFF_SECONDS = 0.8
"""What a person just set is not set back before the world has had time to follow."""


class MirroredControl:
    """One control that follows the world."""

    def __init__(self, control: Any) -> None:
        """Follow with this control of viser's."""
        self.control = control
        self._own = control.update_timestamp

    def follow(self, value: Any) -> None:
        """Show this value, unless a person has only just set another."""
        control = self.control
        if control.value == value:
            return
        edited = control.update_timestamp  # viser stamps an edit before it tells anybody of it
        if edited != self._own and time() - edited < HANDS_OFF_SECONDS:
            return
        control.value = value
        self._own = control.update_timestamp

    def release(self) -> None:
        """The person now looks at something else: follow at once."""
        self._own = self.control.update_timestamp


def set_options(dropdown: Any, options: tuple[str, ...]) -> None:
    """Have a dropdown offer these options; its choice is kept if it is among them.

    A page may have sent any text as its choice: that is set back too.
    """
    chosen = dropdown.value
    if dropdown.options != options:
        dropdown.options = options
    if chosen not in options:
        chosen = options[0]
    assign(dropdown, "value", chosen)


def assign(handle: Any, name: str, value: object) -> None:
    """Set a property if it differs; viser would send it again."""
    if getattr(handle, name) != value:
        setattr(handle, name, value)
