"""Laws of putting other controllers into a study."""

from collections.abc import Callable
from pathlib import Path

import pytest

from agents.controllers.own import load_controller
from experiments.study.controllers import with_controllers
from experiments.study.grid import trials
from experiments.study.results import run_and_write
from experiments.study.study import load, parse, shipped
from experiments.trials.batch import Place
from formation.errors import StudyError
from formation.loading.source import LOADED
from tests.user_code import clean, hold_slot

__all__ = ["clean", "hold_slot"]
Write = Callable[..., str]
SMALL = {
    "name": "small",
    "scenarios": ["triangle-circle"],
    "overrides": {"duration": 0.5, "robots": {}},
    "seeds": 2,
    "measures": ["distance_rms_m"],
    "axes": [{"name": "latency", "key": "link.latency", "values": [0.0, 0.1]}],
    "figures": [{"name": "distance", "kind": "bands", "value": "distance_rms_m", "x": "latency"}],
}


@pytest.mark.parametrize("name", shipped())
def test_every_shipped_study_takes_other_controllers(name: str) -> None:
    study = with_controllers(load(name), ["nash", "paper"])
    axis = next(axis for axis in study.axes if axis.name == "controller")
    assert axis.labels == ["nash", "paper"]


def test_a_study_without_such_an_axis_gets_one_and_a_line_each() -> None:
    study = with_controllers(parse(SMALL), ["nash", "consensus"])
    assert study.trials == 8
    assert study.figures[0].by == "controller"


def test_a_controller_twice_is_refused() -> None:
    with pytest.raises(StudyError, match="every controller once"):
        with_controllers(parse(SMALL), ["nash", "nash"])


def test_workers_get_the_text_and_a_changed_text_is_another_trial(hold_slot: Write, tmp_path: Path) -> None:
    name = load_controller(hold_slot()).name
    study = with_controllers(parse(SMALL), ["nash", name])
    keys = [trial.key for trial in trials(study)]
    outcome = run_and_write(study, Place(tmp_path, workers=1), tell=print, progress=lambda *_: None)
    assert {row["controller"] for row in outcome.statistics} == {"nash", name}
    LOADED.clear()
    load_controller(hold_slot("x = 1"))
    changed = [trial.key for trial in trials(study)]
    assert [one == other for one, other in zip(keys, changed, strict=True)] == [True] * 4 + [False] * 4
