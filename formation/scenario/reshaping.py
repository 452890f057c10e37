"""The scenario of a run whose users change shape or spacing: as if `formation.changes` had had that change."""

from collections.abc import Collection, Iterable
from typing import Any

from pydantic import ValidationError

from formation.clear.opening import opening
from formation.errors import ScenarioError
from formation.formation_spec import MAX_CHANGES, Change, Shape
from formation.metrics import nearest
from formation.offsets import SHARE, assignment
from formation.scenario.fitting import factor, too_narrow
from formation.scenario.scenario import Scenario
from formation.shapes import FIXED_SIZES
from formation.validation import problems

AT_REST = 4.0
"""A driven formation may stand: its robots need so long at least to change places [s]."""


def change_of(
    scenario: Scenario,
    at: float,
    *,
    shape: str | None = None,
    spacing: float | None = None,
    over: float | None = None,
    away: Collection[int] = (),
) -> Change:
    """The change to a shape, to a spacing, or to both, with each robot's place named: nobody need assign them again.

    Args:
        scenario: as it is now.
        at: when it begins, by the path's time [s].
        shape: its name; if absent the shape stays.
        spacing: between neighbours [m]; if absent it stays.
        over: how long it takes [s]; derived if absent.
        away: robots that have no place in it.

    Raises:
        ScenarioError: neither is given, or it is no shape for so many robots.
    """
    if shape is None and spacing is None:
        raise ScenarioError("shape: expected the name of a shape, a spacing, or both")
    rows = [row for row in range(scenario.size) if row + 1 not in away]
    here = scenario.offsets.after(at)[rows]
    n, apart = len(rows), nearest(here)[2]
    try:
        if shape is None:
            there = here * (spacing / apart if spacing is not None else 1.0)
        else:
            robots = None if shape in FIXED_SIZES else n
            named = Shape.model_validate(
                {"shape": shape, "spacing": apart if spacing is None else spacing, "robots": robots}
            )
            there = named.array_for(n)
            there = there[assignment(here, there)]
        if over is None and scenario.driven:
            peak = opening(here, there, list(range(n)), scenario.bodies.width(scenario.size)).peak
            over = max(AT_REST, peak / (SHARE * scenario.law.speed))
        wanted = {"at": at, "offsets": there.tolist(), "spacing": nearest(there)[2], "reassign": False}
        more = {"over": over, "without": sorted(away) or None, "named": shape or _form(scenario, at)[0]}
        return Change.model_validate({**wanted, **{key: value for key, value in more.items() if value is not None}})
    except ValidationError as error:
        raise ScenarioError("; ".join(problems(error, Change))) from None
    except ValueError as error:
        raise ScenarioError(f"shape: {error}") from None


def closing(scenario: Scenario, at: float, away: Collection[int]) -> Change:
    """The change by which the robots of the ring take the shape that the formation has, for as many as they are.

    Args:
        scenario: as it is now.
        at: when it begins, by the path's time [s].
        away: robots that have left the ring.

    Raises:
        ScenarioError: the shape that it has now is none that has a name.
    """
    shape, spacing = _form(scenario, at)
    if shape is None:
        raise ScenarioError("shape: expected the name of a shape that fewer robots can take; it has none")
    if FIXED_SIZES.get(shape, 0) not in (0, scenario.size - len(away)):
        shape = "polygon"
    return change_of(scenario, at, shape=shape, spacing=spacing, away=away)


def _form(scenario: Scenario, at: float) -> tuple[str | None, float]:
    """The name of the shape that the formation has or takes at a time [s], and its spacing [m]."""
    formation = scenario.formation
    found: tuple[str | None, float] = formation.shape, formation.spacing
    for change in formation.changes:
        if change.at <= at:
            found = change.shape or change.named, change.spacing
    return found


def reshaped(scenario: Scenario, changes: Iterable[Change]) -> Scenario:
    """The scenario with these changes as well.

    Raises:
        ScenarioError: robots would come too near to each other, or this scenario cannot have them.
    """
    new = [change.model_dump(exclude_unset=True, mode="json") for change in changes]
    if not new:
        return scenario
    raw = scenario.model_dump(exclude_unset=True)
    formation = raw["formation"]
    both = [*formation.get("changes", ()), *new]
    if len(both) > MAX_CHANGES:
        raise ScenarioError(
            f"shape: expected at most {MAX_CHANGES} changes of it in an episode; a reset begins a new one"
        )
    try:
        found = Scenario.model_validate(
            {**raw, "formation": {**formation, "changes": sorted(both, key=lambda one: float(one["at"]))}}
        )
    except ValidationError as error:
        raise ScenarioError("; ".join(problems(error, Scenario))) from None
    if (by := factor(found)) > 1.0:
        raise ScenarioError(f"shape: {too_narrow(found, by)}")
    return found


def with_changes(scenario: Scenario, changes: Iterable[dict[str, Any]]) -> Scenario:
    """The same of the changes as a Setup has them."""
    return reshaped(scenario, [Change.model_validate(change) for change in changes])
