"""What every test may rely on: reproducible examples, without a time limit (a kernel may load on the first).

`./echelon test` runs two at a time: those that start processes or a browser one after the other, because they watch
the clock, and beside them the others, file by file.
"""

import re
from functools import cache
from pathlib import Path
from typing import Any

import pytest
from hypothesis import settings

from runtime.precompile import ensure_compiled

ROOT = Path(__file__).parent.parent
LIVE = re.compile(r"pytest\.mark\.(processes|browser)")

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


@cache
def group_of(file: str) -> str:
    marks = LIVE.search((ROOT / file).read_text(encoding="utf-8"))
    return "live" if marks else file
