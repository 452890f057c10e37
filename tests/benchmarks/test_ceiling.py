"""The bare processes of a run play their part, and leave nothing behind."""

import psutil
import pytest

from benchmarks import bare
from tests.exceptions import needs


@pytest.mark.processes
def test_bare_processes_answer_every_tick_and_end() -> None:
    needs("unix sockets")
    sizes = {"Tick": 300, "Plan": 700, "Command": 150, "Status": 1700, "State": 700}
    found = bare.measure(2, 0.5, sizes)
    assert found.rate > 0.0
    assert found.us > 0.0
    assert found.missed == 0.0
    assert not [child for child in psutil.Process().children() if "benchmarks.bare" in child.cmdline()]
