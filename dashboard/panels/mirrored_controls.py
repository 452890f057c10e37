"""Controls that mirror a value of the world and can yet be set by a user."""

from time import time
from typing import Any

from dashboard.edits import between_edits

HOLD_SECONDS = 0.8
"""A user's value is kept for so long, until the world has had time to take it over [s]."""


class MirroredControl:
    """One control of viser's that shows a value of the world."""

    def __init__(self, control: Any) -> None:
        self.control = control
        self._own = control.update_timestamp

    def show(self, value: Any) -> None:
        """Show the world's value, unless a user has set another within HOLD_SECONDS."""
        if self.control.value != value:
            between_edits(self.control, self._write, value)

    def _write(self, value: Any) -> None:
        control = self.control
        edited = control.update_timestamp
        if control.value == value or (edited != self._own and time() - edited < HOLD_SECONDS):
            return
        control.value = value
        self._own = control.update_timestamp

    def release(self) -> None:
        """Show the world's next value at once: the control now stands for something else."""
        self._own = self.control.update_timestamp


def set_options(dropdown: Any, options: tuple[str, ...]) -> None:
    """Set a dropdown's options; its value is kept if it is one of them, else it becomes the first.

    A page may have sent any text as the value: that is replaced too.
    """
    if dropdown.options != options or dropdown.value not in options:
        between_edits(dropdown, _write_options, dropdown, options)


def _write_options(dropdown: Any, options: tuple[str, ...]) -> None:
    chosen = dropdown.value
    if dropdown.options != options:
        dropdown.options = options
    if chosen not in options:
        chosen = options[0]
    set_if_changed(dropdown, "value", chosen)


def set_if_changed(handle: Any, name: str, value: object) -> None:
    """Set a property of a handle if it differs; viser would send it again."""
    if getattr(handle, name) != value:
        setattr(handle, name, value)
