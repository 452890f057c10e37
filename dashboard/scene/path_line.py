"""The reference path as points and dashes, relative to the local origin."""

import numpy as np

from dashboard.scene import geometry
from dashboard.telemetry.origin import origin_of
from formation.arrays import FloatArray
from formation.scenario.scenario import Scenario

DASH = 0.02
"""Length of a dash [m]."""


def path_points(scenario: Scenario) -> FloatArray:
    """Points (1001, 2) of the reference path, once around or over the episode; where it begins, if it is driven [m]."""
    origin = origin_of(scenario)
    if scenario.driven:
        return np.array([scenario.path.position(np.array(0.0))]) - origin
    period = scenario.path.period
    seconds = scenario.duration if period is None else period
    return np.asarray(scenario.path.position(np.linspace(0.0, seconds, 1001)) - origin)


def path_dashes(scenario: Scenario) -> FloatArray:
    """Dashes (M, 2, 2) along the reference path [m]."""
    return geometry.dashed(path_points(scenario), DASH)
