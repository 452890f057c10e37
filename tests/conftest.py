"""What every test may rely on: reproducible examples, without a time limit (a kernel may load on the first).

`./echelon test` runs two at a time: those that watch the clock one by one, which are the page's and then those of live
runs; beside them all others, file by file, which give way: a browser without a graphics card wants both cores.
"""

import os
from typing import Any

import pytest
from hypothesis import settings

from runtime.precompile import ensure_compiled

WATCH_THE_CLOCK = ("tests/browser/", "tests/processes/")
"""Folders of tests that do; one worker takes them all, in this order."""
OTHERS_GIVE_WAY = 10
"""How nice the others are."""

settings.register_profile("echelon", max_examples=40, deadline=None, derandomize=True, database=None)
settings.load_profile("echelon")


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_setupnodes() -> None:
    """Two workers that compile the same kernels would take twice the time."""
    ensure_compiled(print)


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config: pytest.Config, log: Any) -> Any:
    """Gives a worker one file after the other; all of WATCH_THE_CLOCK are as one file."""
    from xdist.scheduler import LoadScopeScheduling

    class ByFile(LoadScopeScheduling):  # type: ignore[misc]
        def _split_scope(self, nodeid: str) -> str:
            return group_of(nodeid.split("::", 1)[0])

    return ByFile(config, log)


def group_of(file: str) -> str:
    return "the clock" if file.startswith(WATCH_THE_CLOCK) else file


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """The longest first."""
    items.sort(key=lambda item: not item.location[0].startswith(WATCH_THE_CLOCK))


def pytest_runtest_setup(item: pytest.Item) -> None:
    if "PYTEST_XDIST_WORKER" in os.environ and not item.location[0].startswith(WATCH_THE_CLOCK):
        os.nice(max(0, OTHERS_GIVE_WAY - os.nice(0)))
