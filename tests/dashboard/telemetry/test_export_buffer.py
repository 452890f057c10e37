"""Laws of the export buffer: the newest rows of one episode, in order."""

import numpy as np

from dashboard.telemetry.export_buffer import AWAY, CUT, DEAD, HELD, LOST, ROWS, ExportBuffer
from dashboard.telemetry.links import ring_links
from formation.faults import Fault
from formation.link_ids import LinkId
from network.values import Event
from tests.builders import state
from tests.dashboard.fakes import kept


def test_before_the_first_state_there_are_no_data() -> None:
    assert ExportBuffer().data() is None


def test_the_last_rows_are_kept_in_order_and_no_more() -> None:
    export_buffer = ExportBuffer()
    for tick in range(ROWS + 50):
        message = state(stamp=0.1 * tick)
        export_buffer.add(message, ring_links(message, {}), {})
    data = export_buffer.data()
    assert data is not None
    np.testing.assert_allclose(data.t, 0.1 * np.arange(50, ROWS + 50))
    assert data.flags.shape == (ROWS, 3)


def test_states_that_come_fast_are_thinned() -> None:
    data = kept(*(state(stamp=0.05 * tick) for tick in range(21)))
    np.testing.assert_allclose(data.t, 0.1 * np.arange(11))


def test_while_paused_the_newest_state_replaces_the_last_row() -> None:
    data = kept(state(stamp=0.0, live=[]), state(stamp=0.0, live=[1, 2, 3]))
    assert len(data.t) == 1
    assert not (data.flags & DEAD).any()


def test_another_episode_begins_anew_with_its_own_events() -> None:
    first, second = Event(1, 5.0, "fault", "1->2: cut"), Event(2, 0.0, "run", "reset")
    data = kept(
        state(stamp=5.0, events=(first,)),
        state(stamp=0.0, episode=1, events=(first, second)),
        state(stamp=0.1, episode=1),
    )
    assert list(data.t) == [0.0, 0.1]
    assert data.events == (second,)
    more = kept(state(robots=3), state(robots=5, episode=1))
    assert more.robots == 5


def test_flags_tell_who_is_lost_held_and_cut() -> None:
    data = kept(state(live=[1, 2], stopped=[3], faults={LinkId(1, 2): Fault(cut=True)}))
    assert [int(flags) for flags in data.flags[0]] == [LOST | CUT, LOST, DEAD | HELD], "nobody hears robot 2"
    data = kept(state(live=[1, 2, 3], away=[2], faults={LinkId(1, 3): Fault(cut=True)}))
    assert [int(flags) for flags in data.flags[0]] == [LOST | CUT, AWAY, 0], "the ring is closed over robot 2"
