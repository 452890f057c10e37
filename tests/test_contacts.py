"""The benchmark of contacts: what it draws, and a few of its runs."""

import pytest

from benchmarks.contacts import NETWORKS, RUNS, cases, clean, trial
from formation.bodies.presets import PRESETS
from formation.scenario.files import shipped


def test_every_pair_of_scenario_preset_and_network_is_drawn() -> None:
    drawn = cases()
    assert len(drawn) == RUNS
    assert len({(case.scenario, case.preset) for case in drawn}) == len(shipped()) * len(PRESETS)
    assert len({(case.scenario, case.network) for case in drawn}) == len(shipped()) * len(NETWORKS)
    assert len({(case.preset, case.network) for case in drawn}) == len(PRESETS) * len(NETWORKS)


@pytest.mark.parametrize("number", [113])
def test_runs_that_touch_without_the_filter_are_clean_with_it(number: int) -> None:
    case = cases()[number]
    assert trial(case, "without")["contacts"] > 0
    assert clean(trial(case, "nash"))
