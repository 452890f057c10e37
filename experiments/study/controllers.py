"""Other controllers in a study: the values of its axis of controllers are replaced, or it gets such an axis."""

from collections.abc import Sequence
from typing import Any

from experiments.study.study import Axis, FigureSpec, Study, parse
from formation.errors import StudyError
from formation.scenario.overrides import at_path

AXIS = "controller"
"""Name of the axis, and of its column."""


def with_controllers(study: Study, names: Sequence[str]) -> Study:
    """The study with these controllers side by side; what speaks of others is left out.

    Args:
        study: which one.
        names: of controllers that this process knows.

    Raises:
        StudyError: a name twice, or the study has an axis of this name for something else.
    """
    if len(set(names)) < len(names):
        raise StudyError(f"--controller: expected every controller once; got {', '.join(names)}")
    there = next((axis for axis in study.axes if axis.name == AXIS), None)
    if there is not None and not all(key.startswith("controller.") for key in there.set_keys()):
        raise StudyError(f"--controller: expected a study whose axis {AXIS} names controllers; got {study.name}")
    axis = Axis(name=AXIS, choices={name: at_path("controller.name", name) for name in names})
    axes = [axis if one is there else one for one in study.axes] if there else [axis, *study.axes]
    raw: dict[str, Any] = study.model_dump(exclude_unset=True)
    raw["axes"] = [one.model_dump(exclude_unset=True) for one in axes]
    raw["figures"] = [_lines(drawn, names, added=there is None) for drawn in study.figures if _fits(drawn.only, names)]
    raw["bounds"] = [b.model_dump(exclude_unset=True) for b in study.bounds if b.where.get(AXIS, names[0]) in names]
    if study.baseline.get(AXIS, names[0]) not in names:
        raw["baseline"] = {**study.baseline, AXIS: names[0]}
    return parse(raw, where=study.name)


def _fits(only: dict[str, Any], names: Sequence[str]) -> bool:
    return AXIS not in only or bool(set(only[AXIS]) & set(names))


def _lines(drawn: FigureSpec, names: Sequence[str], *, added: bool) -> dict[str, Any]:
    """A figure with a line a controller, if the study has none of its own, and with none that is not there."""
    raw = drawn.model_dump(exclude_unset=True)
    if added and drawn.kind in ("bands", "recovery"):
        free = next((key for key in ("by", "panels") if getattr(drawn, key) is None), None)
        raw |= {free: AXIS} if free else {}
    if AXIS in drawn.only:
        raw["only"] = {**drawn.only, AXIS: [name for name in drawn.only[AXIS] if name in names]}
    return raw
