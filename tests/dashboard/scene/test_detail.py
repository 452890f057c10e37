"""Laws of detail: lines keep their ends, points and colours fit each other, and a crowd has few corners."""

import numpy as np
import pytest

from dashboard.scene.detail import CROWD, DETAILS, WHOLE, detail
from formation.scenario.files import load
from formation.schema import MAX_ROBOTS
from tests.dashboard.fakes import page_of

MOST_CORNERS = 200_000
"""Of a formation of any size."""
CORNERS_OF_A_SEGMENT = 8


@pytest.mark.parametrize("kind", [WHOLE, *(found for _, found in DETAILS), CROWD])
@pytest.mark.parametrize("count", [2, 3, 21, 60])
def test_the_ends_of_a_line_are_kept(kind: type, count: int) -> None:
    line = np.arange(2.0 * count).reshape(1, count, 2)
    thinned = kind.thinned(line)  # type: ignore[attr-defined]
    assert len(thinned[0]) == len(kind.points(count))  # type: ignore[attr-defined]
    np.testing.assert_array_equal(thinned[0, [0, -1]], line[0, [0, -1]])


def test_few_robots_are_drawn_in_all_detail() -> None:
    line = np.zeros((1, 60, 2))
    assert detail(3).thinned(line) is line


@pytest.mark.parametrize("robots", [21, 101, MAX_ROBOTS])
def test_whatever_is_drawn_of_many_robots_fits_together_and_has_few_corners(robots: int) -> None:
    scenario = load("circle", ["formation.shape='polygon'", f"formation.robots={robots}", "formation.spacing=0.1"])
    corners = 0
    with page_of(scenario) as page:
        for name, node in page._scene._nodes.items():
            if hasattr(node, "points"):
                assert node.colors.shape == node.points.shape, name
                corners += CORNERS_OF_A_SEGMENT * len(node.points)
            elif hasattr(node, "batched_positions"):
                assert len(node.batched_colors) == len(node.batched_positions) == robots, name
                corners += robots * len(node.vertices)
    assert corners < MOST_CORNERS
