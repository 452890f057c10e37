"""The bare processes of a run play their part, and leave nothing behind."""

import psutil
import pytest

from benchmarks import bare
from tests.exceptions import needs


@pytest.mark.processes
@pytest.mark.parametrize("work", [bare.NO_WORK, bare.Work(agent=2e-3, world=3e-3)])
def test_bare_processes_answer_every_tick_and_end(work: bare.Work) -> None:
    needs("unix sockets")
    sizes = {"Tick": 300, "Plan": 700, "Command": 150, "Status": 1700, "State": 700}
    found = bare.measure(2, 0.5, sizes, work=work)
    assert 0.0 < found.rate < 1.0 / (work.agent + work.world or 1e-9)
    assert found.us >= 1e6 * (2 * work.agent + work.world)
    assert found.us > 0.0
    assert found.missed == 0.0
    assert not [child for child in psutil.Process().children() if "benchmarks.bare" in child.cmdline()]
