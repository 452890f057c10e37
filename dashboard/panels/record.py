"""The button that records the run, and how the record stands."""

from pathlib import PurePath

import viser

from dashboard.edits import on_edit
from dashboard.requests import RequestQueue
from dashboard.theme.templates import render
from network.control import Record
from network.messages import State

START, STOP = "Record", "Stop recording"
HINT = "Records the run in a file (.mcap) in the folder that it was started from, for replay, verify and tools of ROS 2"


class RecordPanel:
    """Asks for a recorder, or for its end."""

    def __init__(self, gui: viser.GuiApi, requests: RequestQueue) -> None:
        """A button in the current container of the page."""
        self._note = gui.add_html("")
        self._button = gui.add_button(START, icon=viser.Icon.PLAYER_RECORD, hint=HINT)
        self._drawn = ""
        on_edit(self._button, lambda edit: requests.ask(Record(on=self._button.label == START), edit.page))

    def draw(self, state: State) -> None:
        """Show how the record stands."""
        label = START if state.recording is None else STOP
        if self._button.label != label:
            self._button.label = label
        text = note(state)
        if text != self._drawn:
            self._note.content = self._drawn = text


def note(state: State) -> str:
    """HTML of the file's name, its size and time; empty while nothing is recorded."""
    recording = state.recording
    if recording is None:
        return ""
    name = PurePath(recording.file).name
    return render("panels/record.html", name=name, size=recording.bytes / 1e6, seconds=recording.seconds)
