"""Laws of the replay: nothing is lost, no text becomes code, and it needs no network."""

import base64
import dataclasses
import json
import re

import numpy as np

from dashboard.export.replay import as_replay
from dashboard.scene.path_line import path_points
from dashboard.telemetry.export_buffer import ExportData
from dashboard.theme.palette import DARK
from formation.scenario.files import load
from network.values import Event, Excursion
from tests.builders import state
from tests.dashboard.fakes import kept

EVIL = "</script><script>alert(1)</script><!-- \u2028 & \"' =1+1"


def read(replay: bytes) -> dict[str, object]:
    found = re.search(r'<script id="data" type="application/json">(.*?)</script>', replay.decode(), re.DOTALL)
    assert found is not None
    data: dict[str, object] = json.loads(found[1])
    return data


def replay_of(data: ExportData) -> bytes:
    scenario = load("triangle-circle")
    return as_replay("run", data, scenario, path_points(scenario), DARK)


def test_a_replay_holds_every_pose() -> None:
    poses = np.arange(9.0).reshape(3, 3)
    fields = read(replay_of(kept(state(stamp=1.0, poses=poses), state(stamp=1.1, poses=poses + 1.0))))
    values = fields["values"]
    assert isinstance(values, dict)
    x = np.frombuffer(base64.b64decode(values["x"]), "<f4").reshape(-1, 3)
    np.testing.assert_array_equal(x, [poses[:, 0], poses[:, 0] + 1.0])
    assert fields["start"] == 1.0


def test_a_replay_holds_the_ledger_with_the_last_that_is_known_of_each_excursion() -> None:
    begun = Excursion(1, 2, at=1.0, peak=0.03, peak_at=1.0, cause="1->2: cut", cause_at=0.4)
    over = dataclasses.replace(begun, peak=0.05, until=1.8, recovery=0.3)
    states = [state(stamp=t, excursions=(one,), excursion_limit=0.01) for t, one in ((1.0, begun), (2.0, over))]
    fields = read(replay_of(kept(*states)))
    assert fields["excursions"] == [[1.0, 2, 0.05, 1.8, 0.3, "1->2: cut", 0.4]]
    assert fields["excursionLimit"] == 0.01


def test_no_text_breaks_out_of_a_replay() -> None:
    replay = replay_of(kept(state(scenario=EVIL, controller=EVIL, events=(Event(1, 1.0, "fault", EVIL),))))
    assert replay.count(b"</script>") == 2
    assert b"alert(1)</" not in replay
    fields = read(replay)
    assert fields["scenario"] == EVIL
    assert fields["events"] == [[1.0, "fault", EVIL]]


def test_a_replay_asks_nothing_of_any_network() -> None:
    text = replay_of(kept(state())).decode()
    assert "default-src 'none'" in text
    assert not re.search(r"https?://|<link|<img|@import|fetch\(|XMLHttp|innerHTML|eval\(", text)
