"""What every test may rely on: reproducible examples, without a time limit (a kernel may load on the first).

`./echelon test` runs those of the page by themselves, because a browser without a graphics card takes both cores. Then
it runs two at a time: those of live runs one after the other, because they watch the clock, the others beside them.
"""

from typing import Any

import pytest
from hypothesis import settings

from runtime.precompile import ensure_compiled

LIVE = ("tests/browser/", "tests/processes/")
"""Folders of tests that watch the clock: they share a worker."""

settings.register_profile("echelon", max_examples=40, deadline=None, derandomize=True, database=None)
settings.load_profile("echelon")


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_setupnodes() -> None:
    """Two workers that compile the same kernels would take twice the time."""
    ensure_compiled(print)


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config: pytest.Config, log: Any) -> Any:
    """Gives a worker one file after the other, and all files of live runs as if they were one."""
    from xdist.scheduler import LoadScopeScheduling

    class ByFile(LoadScopeScheduling):  # type: ignore[misc]
        def _split_scope(self, nodeid: str) -> str:
            return group_of(nodeid.split("::", 1)[0])

    return ByFile(config, log)


def group_of(file: str) -> str:
    return "live" if file.startswith(LIVE) else file


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Live runs first: they take as long as all the rest."""
    items.sort(key=lambda item: group_of(item.location[0]) != "live")
