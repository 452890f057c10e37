"""Edits of viser's controls: what users set reaches its handler as it was set, and in the order in which it was set.

viser sets a control to what a page sent, on the server's event loop, and has a thread of a pool read it there. By then
the program or another page may have set another value, and of two edits the later may come first. Here handlers run on
the event loop, right after the edit, and so does whatever the program writes.
"""

import asyncio
from collections.abc import Callable
from typing import Any, NamedTuple

import viser


class Edit(NamedTuple):
    """One control was set by a user, or one button pressed."""

    value: Any
    """What it was set to; of a group of buttons, the one that was pressed."""
    client: viser.ClientHandle
    """The page."""

    @property
    def page(self) -> int:
        """Number of the page."""
        return self.client.client_id


def on_edit(control: Any, handler: Callable[[Edit], None], *, slow: bool = False) -> None:
    """Call a handler for every edit by a user; not for what the program writes.

    Args:
        control: any input or button of viser's.
        handler: runs on the event loop, in the order of the edits; it must not wait for anything.
        slow: it may take long: it runs in a thread, in no order.
    """

    async def edited(event: viser.GuiEvent[Any]) -> None:
        if event.client is None:
            return
        edit = Edit(event.target.value, event.client)
        if slow:
            await asyncio.to_thread(handler, edit)
        else:
            handler(edit)

    (control.on_click if hasattr(control, "on_click") else control.on_update)(edited)


def between_edits(control: Any, write: Callable[..., None], *args: Any) -> None:
    """Call a function soon, on the event loop: no edit comes between what it reads of a control and what it writes."""
    control._impl.gui_api._event_loop.call_soon_threadsafe(write, *args)


def set_value(control: Any, value: Any) -> None:
    """Set a control that users edit too, between two edits."""
    between_edits(control, setattr, control, "value", value)
