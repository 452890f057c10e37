"""Laws of the view folder."""

import numpy as np
import pytest

from dashboard.page import Page
from dashboard.scene.layers import outline_colours
from dashboard.theme.palette import DARK
from tests.dashboard.fakes import edit


@pytest.mark.parametrize("choice", ["Robot -5", "Robot 4", "Robot", ""])
def test_a_robot_that_is_not_offered_is_not_followed(page: Page, choice: str) -> None:
    chosen = edit(choice)
    page._view._focus_chosen(chosen)
    for robot in (-4, 0, 4):
        page._view.focus_on(chosen.client, robot)
    assert page._scene.focus is None
    page._view.focus_on(chosen.client, 3)
    assert page._scene.focus == 3
    plain = outline_colours(3, set(), set(), None, DARK)
    for focus in (-4, 0, 4):
        np.testing.assert_array_equal(outline_colours(3, set(), set(), focus, DARK), plain)
