"""What every test may rely on: reproducible examples, without a time limit (a kernel may load on the first).

`./echelon test` runs two at a time: those that start processes or a browser one after the other, because they watch
the clock, and beside them the others, file by file.
"""

import pytest
from hypothesis import settings

from runtime.precompile import ensure_compiled

settings.register_profile("echelon", max_examples=40, deadline=None, derandomize=True, database=None)
settings.load_profile("echelon")


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_setupnodes() -> None:
    """Two workers that compile the same kernels would take twice the time."""
    ensure_compiled(print)


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    for item in items:
        live = any(item.get_closest_marker(name) for name in ("processes", "browser"))
        item.add_marker(pytest.mark.xdist_group("live" if live else item.location[0]))
