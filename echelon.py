"""Echelon from Python: simulate formations, run them as processes, plug in code of your own.

>>> import echelon
>>> result = echelon.simulate("triangle-circle", {"duration": 2, "link": {"latency": 0.3}})
>>> result.poses.shape
(201, 3, 3)

docs/python.md is the manual's page.
"""

import importlib
import os
import sys
from importlib.machinery import ModuleSpec, PathFinder
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from agents.controllers.interface import Observation, Solution
    from api.result import Result, read
    from api.run import Run, launch
    from api.scenarios import load
    from api.simulation import Simulation, simulate
    from api.study import study
    from api.table import Table
    from formation.errors import EchelonError, ScenarioError
    from formation.link_ids import LinkId
    from formation.scenario.controllers import ControllerOptions
    from formation.scenario.scenario import Scenario

__all__ = [
    "ControllerOptions",
    "EchelonError",
    "LinkId",
    "Observation",
    "Result",
    "Run",
    "Scenario",
    "ScenarioError",
    "Simulation",
    "Solution",
    "Table",
    "launch",
    "load",
    "read",
    "simulate",
    "study",
]
_PLACES = {
    "ControllerOptions": "formation.scenario.controllers",
    "EchelonError": "formation.errors",
    "LinkId": "formation.link_ids",
    "Observation": "agents.controllers.interface",
    "Result": "api.result",
    "Run": "api.run",
    "Scenario": "formation.scenario.scenario",
    "ScenarioError": "formation.errors",
    "Simulation": "api.simulation",
    "Solution": "agents.controllers.interface",
    "Table": "api.table",
    "launch": "api.run",
    "load": "api.scenarios",
    "read": "api.result",
    "simulate": "api.simulation",
    "study": "api.study",
}
"""Modules are imported when a name is used: `import echelon` itself takes milliseconds."""
_ROOMS = frozenset(
    {"formation", "network", "agents", "world", "records", "ros", "dashboard", "runtime", "experiments", "api", "cli"}
)
_HERE = os.path.dirname(os.path.abspath(__file__))
_PYTHON = [os.path.dirname(os.__file__), os.path.join(os.path.dirname(os.__file__), "lib-dynload")]


class _OwnModules:
    """Finds our rooms here, and Python's own modules in Python, whatever lies in the current folder."""

    @staticmethod
    def find_spec(name: str, path: object = None, target: object = None) -> ModuleSpec | None:
        """The module, if it is one of these."""
        del target
        if path is not None:
            return None
        if name in _ROOMS:
            return PathFinder.find_spec(name, [_HERE])
        return PathFinder.find_spec(name, _PYTHON) if name in sys.stdlib_module_names else None


def _check_foreign() -> None:
    """Refuse to begin beside a module of another project that has the name of one of ours."""
    for name in sorted(_ROOMS & sys.modules.keys()):
        module = sys.modules[name]
        place = next(iter(getattr(module, "__path__", ())), getattr(module, "__file__", None)) or name
        if os.path.abspath(place) != os.path.join(_HERE, name):
            raise ImportError(
                f"echelon: expected to import its own module {name}; {place} has been imported under this name: "
                "import echelon before it, or rename it"
            )


_check_foreign()
sys.meta_path.insert(0, _OwnModules)


def __getattr__(name: str) -> object:
    if name not in _PLACES:
        raise AttributeError(f"module 'echelon' has no attribute {name!r}: expected one of {', '.join(__all__)}")
    value = getattr(importlib.import_module(_PLACES[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return [*__all__, *globals()]
