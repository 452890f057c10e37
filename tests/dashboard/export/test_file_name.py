"""Laws of the names of exported files."""

import re

from dashboard.export.file_name import file_name
from tests.builders import state
from tests.dashboard.fakes import kept


def test_a_file_is_named_after_run_scenario_and_time() -> None:
    data = kept(state(stamp=12.34))
    assert file_name("my-run", data, ".csv") == "echelon_my-run_triangle-circle_nash_t12.3s.csv"
    odd = file_name("../run", kept(state(scenario='a/b\\c: "d"')), ".html")
    assert re.fullmatch(r"[A-Za-z0-9._-]+", odd)
    assert "/" not in odd
