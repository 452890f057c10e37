"""Figures of studies: a PNG and an SVG of each, the same from the same numbers, with what was asked for."""

# mypy: disable-error-code="no-any-return"

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from experiments.report import style
from experiments.study import panels
from experiments.study.figures import draw
from experiments.study.grid import trials
from experiments.study.intervals import groups
from experiments.study.panels import bands, recovery, surface
from experiments.study.study import Study, Value, parse
from experiments.study.table import rows
from experiments.trials.measures import MEASURES
from experiments.trials.result import TrialResult
from experiments.trials.trial import SERIES_INTERVAL, Trial
from formation.arrays import FloatArray

CONTROLLERS: list[Value] = ["nash", "paper", "a third"]


def study(*figures: dict[str, Any]) -> Study:
    return parse(
        {
            "name": "drawn",
            "scenarios": ["circle"],
            "overrides": {"duration": 4},
            "seeds": 4,
            "warmup": 1,
            "measures": ["distance_rms_m", "recovery_s"],
            "event": {"at": 2, "until": 3, "below": 0.002},
            "axes": [
                {"name": "who", "choices": {str(name): {"seed": k} for k, name in enumerate(CONTROLLERS)}},
                {"name": "late", "key": "link.latency", "values": [0.0, 0.5, 1.0], "unit": "s"},
            ],
            "baseline": {"late": 0.0},
            "figures": list(figures),
        }
    )


def made_up(of: Study) -> tuple[list[Trial], list[TrialResult]]:
    """Made-up results: (1 + place of the controller) x (1 + latency) mm, give or take a seed."""
    found, results = trials(of), []
    for trial in found:
        cell = trial.labels
        size = 1e-3 * (1 + CONTROLLERS.index(cell["who"])) * (1.0 + float(cell["late"])) * (1.0 + 0.01 * trial.seed)
        after = None if cell["who"] == "paper" else size
        series: FloatArray = size * np.arange(1.0, 32.0)
        results.append(TrialResult({"distance_rms_m": size, "recovery_s": after}, "", series))
    return found, results


BANDS = {"name": "bands", "kind": "bands", "value": "distance_rms_m", "x": "late", "by": "who"}
SURFACE = {"name": "surface", "kind": "surface", "value": "distance_rms_m", "x": "late", "y": "who", "log": False}
RECOVERY = {"name": "recovery", "kind": "recovery", "by": "who", "panels": "late"}
SPARSE = {"name": "sparse", "kind": "bands", "value": "recovery_s", "x": "who", "by": "late", "log": False}


def panel() -> Any:
    return style.figure(3.0).subplots()


def test_every_figure_is_drawn_twice_and_to_the_same_bytes(tmp_path: Any) -> None:
    of = study(BANDS, SURFACE, RECOVERY)
    found, results = made_up(of)
    folders = [tmp_path / "one", tmp_path / "other"]
    for folder in folders:
        folder.mkdir()
    first, second = (draw(of, found, results, rows(of, found, results), folder) for folder in folders)
    names = [f"{name}.{kind}" for name in ("bands", "surface", "recovery") for kind in ("png", "svg")]
    assert [file.name for file in first] == names
    for one, other in zip(first, second, strict=True):
        assert one.read_bytes() == other.read_bytes()
        assert one.stat().st_size > 5_000


def test_lines_are_means_over_seeds_in_millimetres() -> None:
    of = study(BANDS)
    found, results = made_up(of)
    axes = panel()
    handles = bands(axes, of, of.figures[0], groups(of, rows(of, found, results)), None, CONTROLLERS)
    assert list(handles) == CONTROLLERS
    for place, line in enumerate(handles.values()):
        np.testing.assert_allclose(line.get_xdata(), [0.0, 0.5, 1.0])
        np.testing.assert_allclose(line.get_ydata(), 1.015 * (1 + place) * np.array([1.0, 1.5, 2.0]))
    assert axes.get_xlabel() == "late [s]"
    assert axes.get_ylabel().endswith("[mm]")
    assert len({line.get_color() for line in handles.values()}) == 3
    assert len({line.get_marker() for line in handles.values()}) == 3
    assert handles["paper"].get_color() == style.controllers()["paper"]


def test_ratios_are_paired_with_the_baseline_and_have_no_unit() -> None:
    of = study(BANDS | {"ratio": True, "log": False, "only": {"who": ["paper"]}})
    found, results = made_up(of)
    axes = panel()
    handles = bands(axes, of, of.figures[0], groups(of, rows(of, found, results)), None, ["paper"])
    np.testing.assert_allclose(handles["paper"].get_ydata(), [1.0, 1.5, 2.0])
    assert "mm" not in axes.get_ylabel()


def test_where_nobody_recovered_there_is_no_point() -> None:
    of = study(SPARSE)
    found, results = made_up(of)
    handles = bands(panel(), of, of.figures[0], groups(of, rows(of, found, results)), None, [0.0])
    np.testing.assert_allclose(handles["0.0"].get_xdata(), [0.0, 2.0])  # of nash, (paper), a third


def test_a_surface_is_the_mean_at_each_point_and_says_its_numbers() -> None:
    of = study(SURFACE)
    found, results = made_up(of)
    axes = panel()
    image = surface(axes, of, of.figures[0], groups(of, rows(of, found, results)), None)
    np.testing.assert_allclose(image.get_array(), 1.015 * np.outer([1, 2, 3], [1.0, 1.5, 2.0]))
    assert [text.get_text() for text in axes.texts] == [f"{v:.3g}" for v in np.asarray(image.get_array()).ravel()]
    # In both halves of the map the ink stands out from its ground.
    assert {text.get_color() for text in axes.texts} == {"white", "black"}


def test_recovery_is_drawn_over_simulated_time_with_its_event_and_threshold() -> None:
    of = study(RECOVERY)
    found, results = made_up(of)
    axes = panel()
    handles = recovery(axes, of, of.figures[0], found, results, 0.5, CONTROLLERS)
    line = handles["nash"]
    np.testing.assert_allclose(line.get_xdata(), 1.0 + SERIES_INTERVAL * np.arange(31))
    np.testing.assert_allclose(
        line.get_ydata(), np.prod(1.0 + 0.01 * np.arange(4)) ** 0.25 * 1.5 * (1.0 + np.arange(31))
    )
    assert any(np.allclose(other.get_ydata(), 2.0) for other in axes.lines)
    assert axes.get_xlabel() == "t [s]"


@pytest.mark.parametrize("spec", [BANDS, SURFACE, RECOVERY])
def test_the_footer_says_study_seeds_and_version(spec: Any, tmp_path: Any, monkeypatch: Any) -> None:
    notes: list[str] = []

    def save(drawn: Any, stem: Path, note: str) -> list[Path]:
        del drawn, stem
        notes.append(note)
        return []

    monkeypatch.setattr(style, "save", save)
    of = study(spec)
    found, results = made_up(of)
    draw(of, found, results, rows(of, found, results), tmp_path)
    (note,) = notes
    assert re.match("study drawn, seeds 0 to 3", note)


def test_every_measure_can_be_shown() -> None:
    units = {measure.unit for measure in MEASURES.values()}
    assert units <= set(panels.SHOWN)


def test_drawing_leaves_matplotlibs_settings_as_they_were(tmp_path: Path) -> None:
    import matplotlib as mpl

    before = dict(mpl.rcParams)
    of = study(BANDS)
    found, results = made_up(of)
    draw(of, found, results, rows(of, found, results), tmp_path)
    assert dict(mpl.rcParams) == before
