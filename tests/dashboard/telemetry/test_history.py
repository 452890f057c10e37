"""Laws of the history behind the plots."""

from dashboard.telemetry.history import History
from dashboard.telemetry.series import POINTS
from network.values import Event
from tests.builders import state


def test_history_begins_anew_with_an_episode_and_never_outgrows_the_plots() -> None:
    history = History()
    for tick in range(2 * POINTS):
        history.add(state(stamp=0.1 * tick), [], {})
    assert len(history.series()["t"]) == POINTS
    history.add(state(stamp=0.0, episode=1), [], {})
    history.add(state(stamp=0.1, episode=1), [], {})
    assert list(history.series()["t"]) == [0.0, 0.1]


def test_an_event_marks_its_time_once() -> None:
    history = History()
    history.add(state(stamp=1.0), [], {})
    event = Event(5, 1.15, "fault", "1->2: cut")
    for stamp in (1.2, 1.3, 1.4):
        history.add(state(stamp=stamp, events=(event,)), [], {})
    assert history.series()["event"].sum() == 1.0
