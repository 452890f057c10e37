"""Laws of the record's note: it says name, size and time, and nothing while nothing is recorded."""

from dashboard.panels.record import note
from network.stretch import Recording
from tests.builders import state


def test_the_note_says_name_size_and_time() -> None:
    recording = Recording(0, 7, 60.0, 0, "/home/me/runs/triangle <b>.mcap", 1_250_000, 95.0)
    text = note(state(recording=recording))
    assert "triangle &lt;b&gt;.mcap" in text
    assert "1.2 MB, 1:35" in text
    assert "/home" not in text


def test_there_is_no_note_while_nothing_is_recorded() -> None:
    assert note(state()) == ""
