"""Laws of what people take away: nothing is lost, nothing runs that should not, and it needs no network."""

import base64
import csv
import io
import json
import re

import numpy as np
import pytest

from dashboard.export.csv_and_replay import as_csv, as_replay, file_name
from dashboard.scene.scene import route_line
from dashboard.telemetry.export_buffer import CUT, DEAD, HELD, LOST, ROWS, ExportBuffer, ExportData
from dashboard.telemetry.links import ring_links
from dashboard.theme.palette import DARK, LIGHT
from formation.scenario.files import load
from network.messages import Event, State
from tests.builders import state, status

EVIL = "</script><script>alert(1)</script><!-- \u2028 & \"' =1+1"


def kept(*states: State) -> ExportData:
    export_buffer = ExportBuffer()
    for said in states:
        export_buffer.add(said, ring_links(said, {}), {})
    found = export_buffer.data()
    assert found is not None
    return found


def read(replay: bytes) -> dict[str, object]:
    found = re.search(r'<script id="data" type="application/json">(.*?)</script>', replay.decode(), re.DOTALL)
    assert found is not None
    data: dict[str, object] = json.loads(found[1])
    return data


def replay_of(record: ExportData) -> bytes:
    scenario = load("triangle-circle")
    return as_replay("run", record, scenario, route_line(scenario), DARK)


def test_before_the_first_state_there_is_nothing_to_take() -> None:
    assert ExportBuffer().data() is None


def test_the_last_rows_are_kept_in_order_and_no_more() -> None:
    export_buffer = ExportBuffer()
    for tick in range(ROWS + 50):
        said = state(stamp=0.1 * tick)
        export_buffer.add(said, ring_links(said, {}), {})
    record = export_buffer.data()
    assert record is not None
    np.testing.assert_allclose(record.t, 0.1 * np.arange(50, ROWS + 50))
    assert record.flags.shape == (ROWS, 3)


def test_states_that_come_fast_are_thinned() -> None:
    record = kept(*(state(stamp=0.05 * tick) for tick in range(21)))
    np.testing.assert_allclose(record.t, 0.1 * np.arange(11))


def test_while_time_stands_still_the_newest_word_counts() -> None:
    record = kept(state(stamp=0.0, live=[]), state(stamp=0.0, live=[1, 2, 3]))
    assert len(record.t) == 1
    assert not (record.flags & DEAD).any()


def test_another_flight_begins_anew_with_its_own_events() -> None:
    first, second = Event(1, 5.0, "fault", "1->2: cut"), Event(2, 0.0, "run", "reset")
    record = kept(
        state(stamp=5.0, events=(first,)),
        state(stamp=0.0, episode=1, events=(first, second)),
        state(stamp=0.1, episode=1),
    )
    assert list(record.t) == [0.0, 0.1]
    assert record.events == (second,)
    more = kept(state(robots=3), state(robots=5, episode=1))
    assert more.robots == 5


def test_a_record_says_who_is_lost_held_and_cut() -> None:
    record = kept(state(live=[1, 2], stopped=[3], faults={"1->2": {"cut": True}}))
    assert [int(flags) for flags in record.flags[0]] == [LOST | CUT, LOST, DEAD | HELD], "nobody hears robot 2"


def test_the_csv_holds_what_the_world_said() -> None:
    said = state(stamp=1.0, distance_errors=np.array([0.001, -0.002, 0.003]), tracking_error=0.004)
    export_buffer = ExportBuffer()
    export_buffer.add(said, ring_links(said, {2: status(2, 1, age=0.25)}), {2: status(2, 1)})
    record = export_buffer.data()
    assert record is not None
    rows = list(csv.DictReader(io.StringIO(as_csv(record).decode())))
    assert len(rows) == 1
    assert float(rows[0]["distance_error_m R2"]) == pytest.approx(-0.002)
    assert float(rows[0]["tracking_error_m"]) == 0.004
    assert float(rows[0]["plan_age_s 1->2"]) == 0.25
    assert rows[0]["plan_age_s 2->3"] == "", "unknown is not zero"
    assert rows[0]["agent_alive R1"] == "1"


def test_every_event_stands_in_the_csv_once_and_none_is_a_formula() -> None:
    events = (Event(1, 0.95, "fault", EVIL), Event(2, 0.0, "run", "=HYPERLINK(1)"), Event(3, 9.0, "run", "later"))
    record = kept(state(stamp=0.0), state(stamp=1.0, events=events), state(stamp=2.0, events=events))
    cells = [row["events"] for row in csv.DictReader(io.StringIO(as_csv(record).decode(), newline=""))]
    assert cells == ["'=HYPERLINK(1)", EVIL, "later"]


def test_a_replay_holds_every_pose() -> None:
    poses = np.arange(9.0).reshape(3, 3)
    data = read(replay_of(kept(state(stamp=1.0, poses=poses), state(stamp=1.1, poses=poses + 1.0))))
    values = data["values"]
    assert isinstance(values, dict)
    x = np.frombuffer(base64.b64decode(values["x"]), "<f4").reshape(-1, 3)
    np.testing.assert_array_equal(x, [poses[:, 0], poses[:, 0] + 1.0])
    assert data["start"] == 1.0


def test_no_text_breaks_out_of_a_replay() -> None:
    replay = replay_of(kept(state(scenario=EVIL, controller=EVIL, events=(Event(1, 1.0, "fault", EVIL),))))
    assert replay.count(b"</script>") == 2
    assert b"alert(1)</" not in replay
    data = read(replay)
    assert data["scenario"] == EVIL
    assert data["events"] == [[1.0, "fault", EVIL]]


def test_a_replay_asks_nothing_of_any_network() -> None:
    text = replay_of(kept(state())).decode()
    assert "default-src 'none'" in text
    assert not re.search(r"https?://|<link|<img|@import|fetch\(|XMLHttp|innerHTML|eval\(", text)


def test_a_file_is_named_after_run_scenario_and_time() -> None:
    record = kept(state(stamp=12.34))
    assert file_name("my-run", record, ".csv") == "echelon_my-run_triangle-circle_nash_t12.3s.csv"
    odd = file_name("../run", kept(state(scenario='a/b\\c: "d"')), ".html")
    assert re.fullmatch(r"[A-Za-z0-9._-]+", odd)
    assert "/" not in odd


def test_both_looks_have_a_colour_for_everything() -> None:
    assert set(DARK.named()) == set(LIGHT.named())
    assert len(set(DARK.identity)) == len(set(LIGHT.identity)) == len(DARK.identity) == len(LIGHT.identity)
