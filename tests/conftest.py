"""What every test may rely on: reproducible examples, without a time limit (a kernel may load on the first).

`./echelon test` runs three at a time: those of the page one by one, those of live runs one by one, and the others file
by file. Who watches the clock goes before: a browser without a graphics card wants both cores.
"""

import os
from typing import Any

import pytest
from hypothesis import settings

from runtime.precompile import ensure_compiled

GIVES_WAY = {"tests/browser": 0, "tests/processes": 5}
"""Folders of tests that watch the clock, each with a worker of its own and how nice that is; the first goes before."""
OTHERS_GIVE_WAY = 10

settings.register_profile("echelon", max_examples=40, deadline=None, derandomize=True, database=None)
settings.load_profile("echelon")


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_setupnodes() -> None:
    """Two workers that compile the same kernels would take twice the time."""
    ensure_compiled(print)


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config: pytest.Config, log: Any) -> Any:
    """Gives a worker one file after the other; a folder of GIVES_WAY is as one file."""
    from xdist.scheduler import LoadScopeScheduling

    class ByFile(LoadScopeScheduling):  # type: ignore[misc]
        def _split_scope(self, nodeid: str) -> str:
            return group_of(nodeid.split("::", 1)[0])

    return ByFile(config, log)


def group_of(file: str) -> str:
    return next((folder for folder in GIVES_WAY if file.startswith(folder + "/")), file)


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """The longest first."""
    order = {folder: rank for rank, folder in enumerate(GIVES_WAY)}
    items.sort(key=lambda item: order.get(group_of(item.location[0]), len(order)))


def pytest_runtest_setup(item: pytest.Item) -> None:
    if "PYTEST_XDIST_WORKER" in os.environ:
        os.nice(max(0, GIVES_WAY.get(group_of(item.location[0]), OTHERS_GIVE_WAY) - os.nice(0)))
