"""A share of benchmarks/chaos.py: the run is whole again after every fault of its processes, and leaves nothing."""

from pathlib import Path

import pytest

from benchmarks.chaos import strikes
from formation.scenario.files import load
from runtime import supervisor
from tests.processes.live import compiled, processes, runs, wait_for

__all__ = ["compiled", "runs"]
IN_VAIN = 25.0
"""A run that takes longer has waited for a silent agent until its patience of 30 s was over [s]."""
SEED, FAULTS = 169, 4
"""Kills, a SIGTERM and a freeze; of world, router and others, one of them of two processes at once."""


@pytest.mark.parametrize("scenario", ["triangle-circle", "follow-the-leader"])
def test_a_run_is_whole_again_after_every_fault(scenario: str, runs: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(supervisor, "DEATH_WINDOW", supervisor.DEATH_WINDOW)  # which the benchmark changes
    found = strikes(load(scenario), FAULTS, SEED, realtime=False)
    assert len(found) == FAULTS
    assert all(one["whole_s"] is not None and one["whole_s"] < IN_VAIN for one in found), found
    assert not list(runs.iterdir())
    wait_for(lambda: not processes(runs), 5.0)
