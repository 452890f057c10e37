"""Laws of the palettes."""

import re

import numpy as np
import pytest

from dashboard.page import Page
from dashboard.panels.link_matrix import link_matrix
from dashboard.panels.robot_table import robot_table
from dashboard.panels.run_summary import run_summary
from dashboard.theme.colours import rgb
from dashboard.theme.palette import DARK, LIGHT, Palette
from formation.arrays import FloatArray

LMS = np.array([[17.8824, 43.5161, 4.11935], [3.45565, 27.1554, 3.86714], [0.0299566, 0.184309, 1.46709]])
"""Linear sRGB to the three cones (Viénot, Brettel and Mollon, 1999)."""
SEEN = {
    "all cones": np.eye(3),
    "protanopia": np.array([[0.0, 2.02344, -2.52581], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]),
    "deuteranopia": np.array([[1.0, 0.0, 0.0], [0.494207, 0.0, 1.24827], [0.0, 0.0, 1.0]]),
}
"""What the cones tell to whom."""
XYZ = np.array([[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]])
APART = 15.0
"""Colours that far apart are told from each other at a glance (CIE 1976)."""


def test_both_themes_have_a_colour_for_everything() -> None:
    assert set(DARK.named()) == set(LIGHT.named())
    assert len(set(DARK.identity)) == len(set(LIGHT.identity)) == len(DARK.identity) == len(LIGHT.identity)


def lab(text: str, cones: FloatArray) -> FloatArray:
    """(3,) CIELAB of a colour "rrggbb" as these cones see it."""
    screen = rgb(text)
    linear = np.where(screen <= 0.04045, screen / 12.92, ((screen + 0.055) / 1.055) ** 2.4)
    seen = np.clip(np.linalg.inv(LMS) @ cones @ LMS @ linear, 0.0, 1.0)
    x, y, z = np.cbrt(XYZ @ seen / XYZ.sum(axis=1))  # none of the colours is dark enough for the linear part
    return np.array([116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)])


@pytest.mark.parametrize("palette", [DARK, LIGHT], ids=["dark", "light"])
@pytest.mark.parametrize("eyes", SEEN)
def test_green_amber_and_red_are_told_apart_also_by_the_colour_blind(palette: Palette, eyes: str) -> None:
    seen = [lab(text, SEEN[eyes]) for text in (palette.ok, palette.warn, palette.bad)]
    for i in range(3):
        assert np.linalg.norm(seen[i] - seen[i - 1]) > APART


def test_some_robots_hues_are_not_so_the_number_stands_beside_every_dot(page: Page) -> None:
    hues = [lab(text, SEEN["deuteranopia"]) for text in DARK.identity]
    assert min(np.linalg.norm(a - b) for i, a in enumerate(hues) for b in hues[:i]) < APART
    snapshot, links, *_ = page._feed.now()
    for html in (
        run_summary(snapshot, links, []),
        robot_table(snapshot, links, page._clickable),
        link_matrix(snapshot, links, page._clickable, ()),
    ):
        dots = re.findall(r'"color:var\(--r(\d)\)">●</span>([^/]{1,16})', html)
        assert [number for number, _ in dots] == ["1", "2", "3"]
        assert all(f"R{number}" in beside for number, beside in dots)
