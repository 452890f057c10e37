"""Laws of the bodies in ticks: what is later than an agent can remember is refused, whoever says it."""

from typing import Any

import pytest

from formation.bodies.nominal import MAX_DELAY
from formation.errors import ScenarioError
from formation.scenario.files import load


@pytest.mark.parametrize("table", ["bodies", "estimator"])
@pytest.mark.parametrize("tick", [0.01, 0.05])
def test_commands_act_at_most_so_many_ticks_late(table: Any, tick: float) -> None:
    changes: dict[str, Any] = {"control_interval": tick, table: {"delay": MAX_DELAY * tick}}
    scenario = load("triangle-circle", changes)
    assert (scenario.nominal.delay if table == "bodies" else scenario.estimator.ticks_late(tick)) == MAX_DELAY
    changes[table] = {"delay": 1e5}
    with pytest.raises(ScenarioError) as caught:
        load("triangle-circle", changes)
    assert f"{table}.delay: expected at most {MAX_DELAY * tick:g} s at this control_interval; got 1" in str(
        caught.value
    )


def test_a_delay_of_the_estimator_may_be_words() -> None:
    assert load("triangle-circle", {"estimator": {"delay": "learn"}}).estimator.ticks_late(0.01) is None


def test_a_localisation_more_often_than_every_tick_is_refused() -> None:
    with pytest.raises(ScenarioError, match=r"bodies.localisation.rate: expected at most 100 a second; got 200"):
        load("triangle-circle", {"bodies": {"localisation": {"rate": 200}}})
