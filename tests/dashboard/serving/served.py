"""A served page with one control of each kind, and clients that speak viser's wire to it."""

from typing import Any

import viser
from websockets.asyncio.client import ClientConnection, connect

from dashboard.serving import server
from dashboard.serving.access import Guard
from tests.dashboard.serving.hostile import message


class Served:
    """A page with one control of each kind, and how often each was set."""

    def __init__(self) -> None:
        self.server = server.serve(Guard("127.0.0.1"), 0, "test")
        gui, self.set = self.server.gui, list[Any]()
        self.controls: dict[str, Any] = {
            "slider": gui.add_slider("S", 0.0, 10.0, 0.1, 1.0),
            "checkbox": gui.add_checkbox("C", False),
            "dropdown": gui.add_dropdown("D", ("a", "b")),
            "button": gui.add_button("B"),
        }
        for control in ("slider", "checkbox", "dropdown"):
            self.controls[control].on_update(lambda event: self.set.append(event.target.value))

    @property
    def uuids(self) -> dict[str, str]:
        return {name: control._impl.uuid for name, control in self.controls.items()}

    def values(self) -> dict[str, Any]:
        return {name: control._impl.value for name, control in self.controls.items()}

    def page(self) -> Any:
        port = self.server.get_port()
        return connect(
            f"ws://127.0.0.1:{port}",
            origin=f"http://127.0.0.1:{port}",  # type: ignore[arg-type]
            subprotocols=[f"viser-v{viser.__version__}"],  # type: ignore[list-item]
            max_size=None,
        )


async def send(page: ClientConnection, *messages: bytes) -> None:
    for each in messages:
        await page.send(each)


def update(uuid: str, value: object) -> bytes:
    return message("GuiUpdateMessage", uuid=uuid, updates={"value": value})
