"""Named robots and the scenario's scale: a formation of 0.1 m spacing is an e-puck's; for wider robots it is scaled.

Spacing, start places, path and speed grow by one factor, so that the episode takes the same time and shows the same
picture. Disturbances and sensors are the robots' own and stay.
"""

import math
from typing import Any

from formation.bodies.presets import PRESETS
from formation.metrics import nearest
from formation.paths.path import multiplied
from formation.scenario.scenario import Scenario

APART = 1.35
"""Robots fit if the centres of any two are this many diameters apart: an e-puck's at 0.1 m."""
STEP = 0.1
"""Factors are whole multiples of this."""


def with_limits(raw: dict[str, Any]) -> dict[str, Any]:
    """A scenario's raw table with the limits of its bodies, where robots.limits does not give them."""
    bodies, robots = raw.get("bodies"), raw.get("robots", {})
    table = {"preset": bodies} if isinstance(bodies, str) else bodies
    if not (isinstance(table, dict) and isinstance(robots, dict)):
        return raw
    preset = PRESETS.get(str(table.get("preset")), {})
    of_bodies = [each for each in (preset.get("limits"), table.get("limits")) if isinstance(each, dict)]
    own = robots.get("limits", {})
    if not of_bodies or not isinstance(own, dict):
        return raw
    merged: dict[str, Any] = {}
    for each in (*of_bodies, own):
        merged |= each
    return {**raw, "robots": {**robots, "limits": merged}}


def factor(scenario: Scenario) -> float:
    """By which factor the scenario's lengths have to grow so that robots of a preset with a footprint fit; 1 if not."""
    if not scenario.bodies.footprint:
        return 1.0
    apart = min(nearest(shape)[2] for shape in scenario.formation.shapes)
    needed = 2.0 * scenario.bodies.radius * APART
    if apart >= needed * (1.0 - 1e-9):
        return 1.0
    return math.ceil(needed / apart / STEP - 1e-9) * STEP


def too_narrow(scenario: Scenario, by: float) -> str:
    """What a user is told whose robots do not fit unless everything grows."""
    width = 2.0 * scenario.bodies.radius
    return (
        f"bodies.preset: expected a formation for robots {width:g} m wide, centres {width * APART:.3g} m apart; got "
        f'one that would have to be {by:.2g} times as large (bodies.fit = "scale" does that)'
    )


def scaled(scenario: Scenario, by: float) -> dict[str, Any]:
    """The scenario's table with all its lengths multiplied."""
    table = scenario.model_dump(exclude_unset=True)
    table["path"] = scenario.path.larger(by)
    formation = scenario.formation.model_dump(exclude_unset=True)
    table["formation"] = _wider(formation, by)
    if "changes" in formation:
        table["formation"]["changes"] = [_wider(change, by) for change in formation["changes"]]
    if scenario.controller.send_when is not None:
        table["controller"]["send_when"] = by * scenario.controller.send_when
    if scenario.robots.poses is not None:
        table["robots"]["poses"] = [(by * x, by * y, theta) for x, y, theta in scenario.robots.poses]
    table["bodies"] = {**scenario.bodies.model_dump(exclude_unset=True), "scaled": by}
    return table


def _wider(shape: dict[str, Any], by: float) -> dict[str, Any]:
    if shape.get("offsets") is not None:
        return {**shape, "offsets": multiplied(shape["offsets"], by)}
    return {**shape, "spacing": by * shape.get("spacing", 0.1)}
