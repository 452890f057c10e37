"""Mistakes are told in the words of who writes scenarios, not in those of the library that finds them."""

from typing import Any

import pytest

from formation.errors import ScenarioError
from formation.scenario.files import load


@pytest.mark.parametrize(
    ("setting", "line"),
    [
        ("disturbances=[{robot=1, at=24", "disturbances: expected a list of tables; got '[{robot=1, at=24'"),
        ("faults=5", "faults: expected a list of tables; got 5"),
        ("faults=[5]", "faults[0]: expected a table; got 5"),
        ("robots=5", "robots: expected a table; got 5"),
        ("path=circle", "path: expected a table; got 'circle'"),
        ("robots.poses=x", "robots.poses: expected a list; got 'x'"),
        ("seed=x", "seed: expected a whole number; got 'x'"),
        ("seed=1.5", "seed: expected a whole number; got 1.5"),
        ("path.radius=x", "path.radius: expected a number; got 'x'"),
        ("link.cut=maybe", "link.cut: expected true or false; got 'maybe'"),
        ("source=5", "source: expected text; got 5"),
        (
            "name=a b",
            "name: expected a name of at most 64 letters, digits and _ . - that begins with a letter or a digit; "
            "got 'a b'",
        ),
        (
            "estimator.delay=x",
            "estimator.delay: expected a time such as 300ms, 0.3s or 2min or one of learn, nominal; got 'x'",
        ),
        ("estimator.lag=-1", "estimator.lag: expected at least 0 or one of learn, nominal; got -1"),
    ],
)
def test_a_value_of_a_wrong_type_is_told_in_the_users_words(setting: Any, line: str) -> None:
    with pytest.raises(ScenarioError) as caught:
        load("circle", [setting])
    assert str(caught.value) == f"circle: {line}"
    assert caught.value.path == line.partition(":")[0]


@pytest.mark.parametrize(
    ("changes", "path", "choice"),
    [
        ({"bodies": "nope"}, "bodies.preset", "camera"),
        ({"bodies": {"preset": "nope"}}, "bodies.preset", "camera"),
        ({"faults": [{"preset": "nope"}]}, "faults[0].preset", "wifi"),
        ({"estimator": {"delay": "nope"}}, "estimator.delay", "learn"),
    ],
)
def test_what_is_chosen_from_a_list_knows_its_key_and_the_list(changes: Any, path: str, choice: str) -> None:
    with pytest.raises(ScenarioError) as caught:
        load("circle", changes)
    assert caught.value.path == path
    assert choice in caught.value.choices
