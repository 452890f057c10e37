"""Laws of the CSV: nothing is lost, and no cell is a formula."""

import csv
import io

import numpy as np
import pytest

from dashboard.export.csv_table import as_csv
from dashboard.telemetry.export_buffer import ExportBuffer
from dashboard.telemetry.links import ring_links
from network.values import Event
from tests.builders import state, status
from tests.dashboard.fakes import kept

EVIL = "</script><script>alert(1)</script><!-- \u2028 & \"' =1+1"


def test_the_csv_holds_the_states_of_the_world() -> None:
    message = state(stamp=1.0, distance_errors=np.array([0.001, -0.002, 0.003]), tracking_error=0.004)
    export_buffer = ExportBuffer()
    export_buffer.add(message, ring_links(message, {2: status(2, 1, age=0.25)}), {2: status(2, 1)})
    data = export_buffer.data()
    assert data is not None
    rows = list(csv.DictReader(io.StringIO(as_csv(data).decode())))
    assert len(rows) == 1
    assert float(rows[0]["distance_error_m R2"]) == pytest.approx(-0.002)
    assert float(rows[0]["tracking_error_m"]) == 0.004
    assert float(rows[0]["plan_age_s 1->2"]) == 0.25
    assert rows[0]["plan_age_s 2->3"] == "", "unknown is not zero"
    assert rows[0]["agent_alive R1"] == "1"


def test_every_event_stands_in_the_csv_once_and_none_is_a_formula() -> None:
    events = (Event(1, 0.95, "fault", EVIL), Event(2, 0.0, "run", "=HYPERLINK(1)"), Event(3, 9.0, "run", "later"))
    data = kept(state(stamp=0.0), state(stamp=1.0, events=events), state(stamp=2.0, events=events))
    cells = [row["events"] for row in csv.DictReader(io.StringIO(as_csv(data).decode(), newline=""))]
    assert cells == ["'=HYPERLINK(1)", EVIL, "later"]
