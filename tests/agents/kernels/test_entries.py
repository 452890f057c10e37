"""Kernels that are called without a look at their arguments get what they were compiled for."""

import sys
from typing import Any

import numpy as np
import pytest

from agents.kernels.jit import CHECKED
from formation.scenario.files import load
from runtime.inprocess import Simulation
from tests.memory_run import MemoryRun
from tests.runtime.test_hashes import FAULTS, NOISE

CONTROLLERS = ("nash", "virtual_structure", "leader_follower", "consensus", "paper")
BODIES = ("bodies.preset=camera", "robots.avoid=true")
FULL = ("controller.hears=both", *BODIES, "faults=[{link='world->2', latency=0.05}]")
"""With these every one of them is called."""
KEYS: list[tuple[str, ...]] = [
    *((f"controller.name={name}",) for name in CONTROLLERS),
    *((f"controller.name={name}", *BODIES) for name in CONTROLLERS),
    FULL,
    ("controller.game=pair", *BODIES),
    ("controller.send_when=0.005", "controller.plan_every=5", *FAULTS, *NOISE),
    ("path.known_to=leader", *FAULTS, *NOISE),
]


@pytest.fixture
def checked(monkeypatch: pytest.MonkeyPatch) -> set[str]:
    """Everybody calls the kernels by numba's dispatcher, which refuses wrong arguments; which were called."""
    called: set[str] = set()

    def noted(entry: Any) -> Any:
        def call(*arguments: Any) -> Any:
            called.add(entry.__name__)
            return CHECKED[entry](*arguments)

        return call

    for module in [module for name, module in sys.modules.items() if name.startswith("agents.")]:
        for name, value in list(vars(module).items()):
            if type(value) is type(len) and value in CHECKED:
                monkeypatch.setattr(module, name, noted(value))
    return called


@pytest.mark.parametrize("keys", KEYS, ids=" ".join)
def test_in_one_process_and_over_the_wire(keys: tuple[str, ...], checked: set[str]) -> None:
    scenario = load("triangle-circle", ["duration=0.6", *keys])
    run = MemoryRun(scenario)
    run.run(30.0, lambda: run.world.finished)
    assert run.world.trace is not None
    np.testing.assert_array_equal(run.world.trace.poses, Simulation(scenario).simulate().poses)
    if keys == FULL:
        assert checked == {entry.__name__ for entry in CHECKED}


def test_a_wrong_argument_is_refused_where_one_looks() -> None:
    for kernel in CHECKED.values():
        with pytest.raises(TypeError):
            kernel(*[None] * len(kernel.signatures[0]))  # type: ignore[attr-defined]
