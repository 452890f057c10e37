"""What a page may send once it is admitted: camera, clicks, drags, commands, and values of offered controls.

viser itself takes any property of any control, from any page, as often as it comes. Here everything else is dropped
before it reaches viser, a page that floods is disconnected, and pages that set one control at once end up with the
same value.
"""

import asyncio
import contextlib
import dataclasses
import functools
import math
import types
import typing
from collections.abc import Callable
from time import monotonic
from typing import Any

import msgspec
import viser
from viser import _messages
from websockets.asyncio.server import ServerConnection

LONGEST = 64 << 10
"""Bytes of a message, except for a picture that a page was asked for."""
LARGEST = 8 << 20
"""Bytes of a picture."""
MOST_PIXELS = 4 << 20
"""Of a picture: a small file may hold a large one."""
RATE, BURST = 200.0, 600.0
"""Messages a second of one page, and at once: those beyond are dropped."""
MOST_DROPPED = 2000
"""A page with more dropped messages is disconnected."""
PAGES = 32
"""Pages at a time; the next are turned away."""
SILENT_SECONDS = 20.0
"""A page tells where its camera is as soon as it is drawn: a connection that has not by then is closed [s]."""
SETTLED_SECONDS = 0.3
"""A control that no page has set for so long is told to all pages [s]."""
MOST, MOST_ITEMS = 1e12, 1000
"""Of a number, and of the items in a list."""
TEXT = 4096
"""Characters of a text."""
KINDS: tuple[type, ...] = (
    _messages.ViewerCameraMessage,
    _messages.GuiUpdateMessage,
    _messages.CommandTriggerMessage,
    _messages.ScenePointerMessage,
    _messages.SceneNodeClickMessage,
    _messages.SceneNodeDragMessage,
    _messages.FileTransferPartAck,
    _messages.GetRenderResponseMessage,
)
"""What our page sends; viser knows more."""
NAMES = {kind.__name__: kind for kind in KINDS}


class Gate:
    """Reads what pages send, and hands on what they may."""

    def __init__(self) -> None:
        """Of a server that is to be made; `server` is set then."""
        self.server: viser.ViserServer | None = None
        self.pages = 0
        """Connections now."""
        self._echoes: dict[str, asyncio.TimerHandle] = {}

    async def consume(self, connection: ServerConnection, handle: Callable[[Any], None], kind: type) -> None:
        """All messages of one page, in place of viser's own loop.

        Args:
            connection: to the page.
            handle: takes a message.
            kind: base class of viser's messages.
        """
        self.pages += 1
        try:
            await self._consume(connection, handle, kind)
        finally:
            self.pages -= 1

    async def _consume(self, connection: ServerConnection, handle: Callable[[Any], None], kind: type) -> None:
        page = _Page()
        while True:
            wait = None if page.drawn else max(0.0, page.began + SILENT_SECONDS - monotonic())
            try:
                raw = await asyncio.wait_for(connection.recv(), wait)
            except TimeoutError:
                await connection.close(1008, "expected a page")
                return
            message = self._message(raw, kind) if page.may_send(len(raw)) else None
            if message is None:
                page.dropped += 1
                if page.dropped > MOST_DROPPED:
                    connection.transport.abort()  # a close that is agreed on would have to read the rest
                    return
            else:
                page.drawn |= isinstance(message, _messages.ViewerCameraMessage)
                handle(message)
            await asyncio.sleep(0)  # what is handed on runs first, and so do other pages

    def _message(self, raw: str | bytes, kind: Any) -> Any:
        """The message, if a page may send it; else None."""
        if not isinstance(raw, bytes) or len(raw) > LARGEST:
            return None
        with contextlib.suppress(Exception):  # a page may send any bytes
            fields = msgspec.msgpack.decode(raw)
            name = fields.get("type")
            if name not in NAMES or (len(raw) > LONGEST and name != "GetRenderResponseMessage"):
                return None
            message = kind.deserialize(raw)
            if self._fits(message):
                return message
        return None

    def _fits(self, message: Any) -> bool:
        if message.excluded_self_client is not None or not _is_typed(message):
            return False
        match message:
            case _messages.GuiUpdateMessage(uuid=uuid, updates=updates):
                return self._sets_value(uuid, updates)
            case _messages.GetRenderResponseMessage(payload=payload):
                return _is_picture(payload)
            case _:
                return True

    # ------------------------------------------------------------------ controls

    def _sets_value(self, uuid: object, updates: object) -> bool:
        """Whether a control that is offered gets a value of its own type, and nothing else."""
        control, shared = self._control(uuid)
        if control is None or not isinstance(updates, dict) or set(updates) != {"value"}:
            return False
        if shared and not isinstance(control, viser.GuiButtonHandle | viser.GuiButtonGroupHandle):
            self._tell_all_later(str(uuid))
        return accepts(control, updates["value"])

    def _control(self, uuid: object) -> tuple[Any, bool]:
        """The control with this id, and whether it is on all pages."""
        server = self.server
        if server is None or not isinstance(uuid, str):
            return None, False
        found = server.gui._gui_input_handle_from_uuid.get(uuid)
        if found is not None:
            return found, True
        for client in server.get_clients().values():
            found = client.gui._gui_input_handle_from_uuid.get(uuid)
            if found is not None:
                return found, False
        return None, False

    def _tell_all_later(self, uuid: str) -> None:
        waiting = self._echoes.pop(uuid, None)
        if waiting is not None:
            waiting.cancel()
        loop = asyncio.get_running_loop()
        self._echoes[uuid] = loop.call_later(SETTLED_SECONDS, self._tell_all, uuid)

    def _tell_all(self, uuid: str) -> None:
        """Every page gets the value that the control has: viser tells it to all but the page that has set it."""
        self._echoes.pop(uuid, None)
        control, shared = self._control(uuid)
        if control is not None and shared and not control._impl.removed:
            message = _messages.GuiUpdateMessage(uuid, {"value": control._impl.value})
            control._impl.gui_api._websock_interface.queue_message(message)


class _Page:
    """How much one page has sent."""

    def __init__(self) -> None:
        self.began = self._at = monotonic()
        self._left = BURST
        self.dropped = 0
        self.drawn = False
        """Whether it has told where its camera is."""

    def may_send(self, length: int) -> bool:
        """Whether another message, of so many bytes, is within its rate."""
        now = monotonic()
        self._left = min(BURST, self._left + RATE * (now - self._at))
        self._at = now
        if self._left < 1.0:
            return False
        self._left -= 1.0 + length // LONGEST
        return True


def accepts(control: Any, value: object) -> bool:
    """Whether a control can have this value: of its type, within its limits, one of its options."""
    if control._impl.removed or getattr(control, "disabled", False):
        return False
    number = isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)
    match control:
        case viser.GuiButtonHandle() | viser.GuiCheckboxHandle():
            return isinstance(value, bool)
        case viser.GuiDropdownHandle() | viser.GuiButtonGroupHandle():
            return value in control.options
        case viser.GuiSliderHandle():
            return number and control.min <= value <= control.max  # type: ignore[operator]
        case viser.GuiTextHandle():
            return isinstance(value, str) and len(value) <= TEXT
        case _:
            return False


def _is_typed(message: Any) -> bool:
    """Whether every field has a value of its type; numbers are finite and no larger than anything on a page."""
    return all(_matches(hint, getattr(message, name, None)) for name, hint in _hints(message.__class__).items())


@functools.cache
def _hints(kind: type) -> dict[str, Any]:
    """The type of each field of a message, looked up once: that takes most of a millisecond."""
    hints = typing.get_type_hints(kind)
    return {field.name: hints[field.name] for field in dataclasses.fields(kind)}


def _matches(hint: Any, value: Any) -> bool:
    if hint is Any:
        return True
    if hint in (float, int):
        kind = int if hint is int else int | float
        return isinstance(value, kind) and not isinstance(value, bool) and math.isfinite(value) and abs(value) < MOST
    if hint in (str, bytes):
        return isinstance(value, hint) and (hint is bytes or len(value) <= TEXT)
    if hint in (bool, type(None)):
        return isinstance(value, hint)
    parts = typing.get_args(hint)
    match typing.get_origin(hint):
        case typing.Union | types.UnionType:
            return any(_matches(part, value) for part in parts)
        case typing.Literal:
            return value in parts
        case kind if kind is dict:
            return isinstance(value, dict)
        case kind if kind is tuple and isinstance(value, tuple | list):
            whole = parts if parts[-1] is not ... else parts[:1] * min(len(value), MOST_ITEMS)
            return len(whole) == len(value) and all(map(_matches, whole, value))
        case _:
            return _matches(hint.__supertype__, value) if isinstance(hint, typing.NewType) else False


def _is_picture(payload: bytes) -> bool:
    """Whether it is a PNG of a size that a page can have."""
    if payload[:8] != b"\x89PNG\r\n\x1a\n" or len(payload) < 24:
        return False
    pixels = int.from_bytes(payload[16:20], "big") * int.from_bytes(payload[20:24], "big")
    return 0 < pixels <= MOST_PIXELS
