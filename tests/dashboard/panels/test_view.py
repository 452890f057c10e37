"""Laws of the view folder."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from dashboard.page import Page
from dashboard.scene.layers import outline_colours
from dashboard.theme.palette import DARK


@pytest.mark.parametrize("choice", ["Robot -5", "Robot 4", "Robot", ""])
def test_a_robot_that_is_not_offered_is_not_followed(page: Page, choice: str) -> None:
    client: Any = SimpleNamespace(client_id=1)
    page._view._focus_chosen(SimpleNamespace(client=client, target=SimpleNamespace(value=choice)))  # type: ignore[arg-type]
    for robot in (-4, 0, 4):
        page._view.focus_on(client, robot)
    assert page._scene.focus is None
    page._view.focus_on(client, 3)
    assert page._scene.focus == 3
    plain = outline_colours(3, set(), set(), None, DARK)
    for focus in (-4, 0, 4):
        np.testing.assert_array_equal(outline_colours(3, set(), set(), focus, DARK), plain)
