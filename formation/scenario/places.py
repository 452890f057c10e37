"""Whether there is room for every robot where a scenario puts it: at the start, and in each shape that it takes."""

from collections.abc import Iterator

import numpy as np

from formation.arrays import FloatArray
from formation.bodies.spec import Bodies
from formation.formation_spec import Formation
from formation.metrics import nearest
from formation.scenario.robots import Robots

SAME_PLACE = 0.01
"""Robots whose centres are nearer to each other than this share of their width stand in the same place."""


def mistakes(formation: Formation, robots: Robots, bodies: Bodies) -> Iterator[str]:
    """What is wrong with the start poses, and with shapes for bodies of this size."""
    size, poses = len(formation.array), robots.poses
    if poses is not None and len(poses) != size:
        yield f"robots.poses: expected {size} poses for this formation; got {len(poses)}"
        return
    width = _width(bodies, size)
    for where, who, apart in _nearest(formation, robots):
        if apart < SAME_PLACE * width:
            got = f"{who} {apart:.3g} m apart, and they are {width:g} m wide"
            yield f"{where}: expected a place for each robot; got {got}"


def overlapping(formation: Formation, robots: Robots, bodies: Bodies) -> str:
    """What a user is told whose robots have less room than they are wide; empty if they have it."""
    width = _width(bodies, len(formation.array))
    for where, who, apart in _nearest(formation, robots):
        if apart < width * (1.0 - 1e-9):
            return f"{where} has {who} {apart:.3g} m apart, and they are {width:g} m wide: they touch"
    return ""


def _width(bodies: Bodies, size: int) -> float:
    """Of the smallest robot [m]."""
    return 2.0 * min(bodies.radii(size))


def _nearest(formation: Formation, robots: Robots) -> Iterator[tuple[str, str, float]]:
    """Per key that says where robots are: its name, the two that are nearest to each other, and how far apart [m]."""
    places: list[tuple[str, FloatArray]] = [("formation", formation.array)]
    if robots.poses is not None and robots.start_noise.position == 0.0:  # with it they start elsewhere
        places.append(("robots.poses", np.array(robots.poses)))
    for where, array in places:
        one, other, apart = nearest(array)
        yield where, f"robots {one} and {other}", apart
    for index, array in enumerate(formation.shapes[1:]):  # who takes which place depends on more
        yield f"formation.changes[{index}]", "two robots", nearest(array)[2]
