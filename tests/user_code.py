"""What tests of code of users' own share: files with classes, and a process that has none of them afterwards."""

from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from agents.controllers.registry import OWN
from formation.loading.source import LOADED
from formation.scenario.registry import CONTROLLERS
from world.bodies.registry import IMPLEMENTATIONS

HOLD_SLOT = """\
import numpy as np
from agents.controllers.interface import Solution

class {name}:
    def __init__(self, task, options):
        self.task, self.options = task, options

    def plan(self, observation):
        {mistake}
        slot, inputs = observation.reference.slots[0], observation.reference.inputs.copy()
        dx, dy = slot[:2] - observation.pose[:2]
        c, s = np.cos(slot[2]), np.sin(slot[2])
        turn = np.sin(slot[2] - observation.pose[2])
        v, omega = inputs[0]
        inputs[0] = v + 2 * (c * dx + s * dy), omega + 2 * turn + 10 * v * (c * dy - s * dx)
        return Solution(np.clip(inputs, -observation.limits, observation.limits))
"""
Write = Callable[..., str]


@pytest.fixture
def clean() -> Iterator[None]:
    """Whatever code a test loads is gone afterwards."""
    tables: list[dict[object, object]] = [LOADED, CONTROLLERS, OWN, IMPLEMENTATIONS]  # type: ignore[list-item]
    before = [dict(table) for table in tables]
    yield
    for table, kept in zip(tables, before, strict=True):
        table.clear()
        table.update(kept)


@pytest.fixture
def hold_slot(tmp_path: Path, clean: None) -> Write:
    """Writes the file of a controller; `mistake` is a statement at the beginning of its plan. Returns FILE.py:CLASS."""

    def write(mistake: str = "pass", *, name: str = "HoldSlot", folder: str = "", more: str = "") -> str:
        (tmp_path / folder).mkdir(exist_ok=True)
        file = tmp_path / folder / "mine.py"
        file.write_text(HOLD_SLOT.format(name=name, mistake=mistake) + more)
        return f"{file}:{name}"

    return write
