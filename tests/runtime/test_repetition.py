"""Laws of a record that is read as a result: it is what simulating gives, to the last bit, or one line."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import echelon
from formation.errors import EchelonError
from records.file import RecordFile
from records.record import load
from records.recorder import Recorder
from runtime import repetition
from runtime.inprocess import Simulation, summary_of
from tests.records.recorded import STARTED, record, scenario
from world.journal import Journal


@pytest.mark.parametrize("detail", ["default", "full"])
def test_a_record_gives_what_simulating_gave(tmp_path: Path, detail: Any) -> None:
    path = tmp_path / "x.mcap"
    simulation = record(path, scenario(), detail)
    found, trace = echelon.read(path), simulation.trace
    for name in ("poses", "inputs", "ages"):
        assert getattr(found, name).tobytes() == getattr(trace, name).tobytes(), name
    ours, theirs = found.summary(), summary_of(simulation, 0.0, 0.0)
    changing = {"wall_s", "engine", "solve_s"}  # of wall-clock time
    assert ours.keys() == theirs.keys()
    for key in ours.keys() - changing:
        assert ours[key] == theirs[key] or np.isnan(ours[key]), key


def test_a_run_beyond_its_duration_is_read_to_its_end(tmp_path: Path) -> None:
    simulation = Simulation(scenario("duration=0.5", "faults=[]", "link.loss=0"), endless=True)
    journal = Journal(simulation.world, wanted=True)
    with RecordFile(tmp_path / "long.mcap") as file:
        recorder = Recorder(file, "run", STARTED)
        for _ in range(120):
            journal.note(simulation.step())
            stretch = journal.take()
            if stretch is not None:
                recorder.take(stretch)
        last = journal.take(all_of_it=True)
        if last is not None:
            recorder.take(last)
    assert len(echelon.read(tmp_path / "long.mcap").inputs) == 120


def test_a_record_that_cannot_be_simulated_again_is_one_line(tmp_path: Path) -> None:
    record(tmp_path / "real.mcap", scenario("duration=0.2"), mode="realtime")
    with pytest.raises(EchelonError, match="depends on the wall clock"):
        echelon.read(tmp_path / "real.mcap")
    record(tmp_path / "x.mcap", scenario("duration=0.2"))
    with pytest.raises(EchelonError, match="expected one of 1 episodes"):
        echelon.read(tmp_path / "x.mcap", episode=1)
    read = load(tmp_path / "x.mcap")
    read.episodes[0].checks[7] = (1, 2, 3)
    with pytest.raises(EchelonError, match="expected what was recorded; tick 7"):
        repetition.repeat(read)
