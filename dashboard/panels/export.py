"""The export buttons: a replay, the plots as CSV, a picture of the view; each is sent to the page that asked."""

import threading
from collections.abc import Callable
from typing import Any

import viser

from dashboard.edits import on_edit
from dashboard.export.csv_table import as_csv
from dashboard.export.file_name import file_name
from dashboard.export.picture import as_png
from dashboard.export.replay import as_replay
from dashboard.notices import Notify
from dashboard.scene.layers import Sizes
from dashboard.scene.numbers import number_lines
from dashboard.scene.path_line import path_points
from dashboard.telemetry.export_buffer import ExportBuffer
from dashboard.telemetry.snapshot import Snapshot
from dashboard.theme.palette import Palette
from formation.arrays import FloatArray
from formation.scenario.scenario import Scenario
from network.throttled_log import ThrottledLog

PICTURE_SECONDS = 15.0
"""How long a page may take to draw its view: one without a graphics card takes seconds."""
REPLAY, CSV, PICTURE = "Replay", "CSV", "Picture"
NUMBERS = (10, 13, 17)
"""Colour of the robots' numbers in a picture."""
HINT = "The last minutes: a replay that plays in any browser, the plots as numbers, or a picture of the view"


class ExportButtons:
    """Makes files and sends them to the page that asked for them."""

    def __init__(
        self,
        gui: viser.GuiApi,
        run: str,
        export_buffer: ExportBuffer,
        palette: Callable[[], Palette],
        notify: Notify,
    ) -> None:
        """Buttons in the current container of the page."""
        self._run, self._export_buffer, self._palette, self._notify = run, export_buffer, palette, notify
        self._snapshot: Snapshot | None = None
        self._busy = threading.Lock()
        self._errors = ThrottledLog()
        group = gui.add_button_group("Export", (REPLAY, CSV, PICTURE), hint=HINT)
        on_edit(group, lambda edit: self._export(edit.value, edit.client), slow=True)
        for what, icon in ((REPLAY, viser.Icon.MOVIE), (CSV, viser.Icon.CSV), (PICTURE, viser.Icon.PHOTO)):
            command = gui.add_command(f"Export: {what}", icon=icon)
            command.on_trigger(lambda event, what=what: self._export(what, event.client))  # type: ignore[misc]

    def update(self, snapshot: Snapshot) -> None:
        """Take over what is shown now."""
        self._snapshot = snapshot

    def _export(self, what: str, client: viser.ClientHandle | None) -> None:
        if client is None:
            return
        if not self._busy.acquire(blocking=False):  # one at a time, which bounds the memory; nobody waits: a page that
            # never answers would keep a thread for each of its requests, and no button would work
            self._notify(client.client_id, "Not exported", "Another file is being made. Try again in a moment.")
            return
        try:
            try:
                made = self._made(what, client)
            except Exception:
                self._errors.add_exception("making a file")
                made = None
            if made is None:
                self._notify(client.client_id, "Nothing to export", "There is no data yet, or the page has no view.")
            else:
                client.send_file_download(*made, save_immediately=True)
        finally:
            self._busy.release()

    def _made(self, what: str, client: viser.ClientHandle) -> tuple[str, bytes] | None:
        """Name and content of the file."""
        data, snapshot = self._export_buffer.data(), self._snapshot
        if data is None or snapshot is None or snapshot.scenario is None or snapshot.scenario.size != data.robots:
            return None
        if what == CSV:
            return file_name(self._run, data, ".csv"), as_csv(data)
        if what == PICTURE:
            return file_name(self._run, data, ".png"), self._picture(client, snapshot.poses, snapshot.scenario)
        if what == REPLAY:
            replay = as_replay(self._run, data, snapshot.scenario, path_points(snapshot.scenario), self._palette())
            return file_name(self._run, data, ".html"), replay
        return None

    def _picture(self, client: viser.ClientHandle, poses: FloatArray, scenario: Scenario) -> bytes:
        camera: Any = client.camera
        lines = number_lines(poses, Sizes.of(scenario))
        numbers = client.scene.add_line_segments("/picture/numbers", lines, NUMBERS, thickness=2.0)
        try:
            drawn = client.get_render(
                camera.image_height, camera.image_width, transport_format="png", timeout=PICTURE_SECONDS
            )
        finally:
            numbers.remove()
        return as_png(drawn, self._palette())
