"""The buttons that take things away: a replay, the plots as CSV, a picture of the view; each to the page that asked."""

import threading
from collections.abc import Callable
from typing import Any

import imageio.v3 as images
import numpy as np
import viser

from dashboard.export import csv_and_replay
from dashboard.scene.scene import route_line
from dashboard.telemetry.export_buffer import ExportBuffer
from dashboard.telemetry.subscriber import Snapshot
from dashboard.theme.palette import Palette
from network.throttled_log import ThrottledLog

PICTURE_SECONDS = 15.0
"""How long a page may take to draw its view: one without a graphics card takes seconds."""
REPLAY, PLOTS, PICTURE = "Replay", "CSV", "Picture"

Notify = Callable[[int | None, str, str], None]


class Saving:
    """Makes files and sends them to the page that asked for them."""

    def __init__(
        self, gui: viser.GuiApi, run: str, export_buffer: ExportBuffer, look: Callable[[], Palette], notify: Notify
    ) -> None:
        """Buttons in the current container of the page."""
        self._run, self._export_buffer, self._look, self._notify = run, export_buffer, look, notify
        self._snapshot: Snapshot | None = None
        self._busy = threading.Lock()
        self._errors = ThrottledLog()
        hint = "The last minutes: a replay that plays in any browser, the plots as numbers, or a picture of the view"
        group = gui.add_button_group("Take away", (REPLAY, PLOTS, PICTURE), hint=hint)
        group.on_click(lambda event: self._save(event.target.value, event.client))
        for what, icon in ((REPLAY, viser.Icon.MOVIE), (PLOTS, viser.Icon.CSV), (PICTURE, viser.Icon.PHOTO)):
            command = gui.add_command(f"Take away: {what}", icon=icon)
            command.on_trigger(lambda event, what=what: self._save(what, event.client))  # type: ignore[misc]

    def note(self, snapshot: Snapshot) -> None:
        """What is shown now."""
        self._snapshot = snapshot

    def _save(self, what: str, client: viser.ClientHandle | None) -> None:
        if client is None:
            return
        with self._busy:  # one at a time: a person who presses often waits, and so does the memory
            try:
                made = self._made(what, client)
            except Exception:
                self._errors.add_exception("making a file")
                made = None
            if made is None:
                self._notify(client.client_id, "Nothing to take away", "No flight was kept yet, or it has no view.")
            else:
                client.send_file_download(*made, save_immediately=True)

    def _made(self, what: str, client: viser.ClientHandle) -> tuple[str, bytes] | None:
        """Name and content of the file."""
        record, snapshot = self._export_buffer.data(), self._snapshot
        if record is None or snapshot is None or snapshot.scenario is None or snapshot.scenario.size != record.robots:
            return None
        if what == PLOTS:
            return csv_and_replay.file_name(self._run, record, ".csv"), csv_and_replay.as_csv(record)
        if what == PICTURE:
            return csv_and_replay.file_name(self._run, record, ".png"), self._picture(client)
        if what == REPLAY:
            replay = csv_and_replay.as_replay(
                self._run, record, snapshot.scenario, route_line(snapshot.scenario), self._look()
            )
            return csv_and_replay.file_name(self._run, record, ".html"), replay
        return None

    def _picture(self, client: viser.ClientHandle) -> bytes:
        """The view as this page has it, on the look's background."""
        camera: Any = client.camera
        drawn = client.get_render(
            camera.image_height, camera.image_width, transport_format="png", timeout=PICTURE_SECONDS
        ).astype(float)
        share = drawn[..., 3:] / 255.0
        background = np.array([int(self._look().background[i : i + 2], 16) for i in (0, 2, 4)])
        flat = drawn[..., :3] * share + background * (1.0 - share)
        return bytes(images.imwrite("<bytes>", flat.round().astype(np.uint8), extension=".png"))
