"""Scenarios by name, file or value, with nested overrides and code of the caller's own."""

import inspect
import sys
from collections.abc import Mapping
from typing import Any

from formation.errors import ScenarioError
from formation.loading.load import names_code
from formation.scenario import files
from formation.scenario.overrides import at_path, merged
from formation.scenario.scenario import Scenario
from runtime.precompile import ensure_compiled
from runtime.user_code import named


def load(
    scenario: str | Scenario = "triangle-circle",
    overrides: Mapping[str, Any] | None = None,
    *,
    controller: str | type | None = None,
    bodies: str | type | None = None,
) -> Scenario:
    """A scenario, checked.

    Args:
        scenario: a shipped name, a TOML file, or a scenario that is to be changed.
        overrides: what differs from it, as nested data; {"bodies": "camera"} is short for its preset.
        controller: a name, code of your own (FILE.py:CLASS, package.module:CLASS, an entry point), or a class.
        bodies: a preset, or code of your own likewise.

    Raises:
        ScenarioError: it does not exist or is wrong; `path` is the first key that is, `choices` what there is.

    Example:
        >>> import echelon
        >>> scenario = echelon.load("triangle-circle", {"link": {"latency": 0.3}, "bodies": "camera"})
        >>> scenario.size, scenario.link.latency, scenario.bodies.preset
        (3, 0.3, 'camera')
    """
    changes = dict(overrides or {})
    if isinstance(changes.get("bodies"), str):
        changes["bodies"] = {"preset": changes["bodies"]}
    if controller is not None:
        changes = merged(changes, at_path("controller.name", name_of(controller, "controller")))
    if bodies is not None:
        own = not isinstance(bodies, str) or names_code(bodies, "bodies")
        key = "bodies.implementation" if own else "bodies.preset"
        changes = merged(changes, at_path(key, name_of(bodies, "bodies") if own else bodies))
    if isinstance(scenario, Scenario):
        return files.parse(scenario.model_dump(mode="json", exclude_unset=True), changes, where=scenario.name)
    return files.load(scenario, changes)


def name_of(code: str | type, kind: Any) -> str:
    """The name of a controller or of bodies; code of the caller's own is loaded.

    Raises:
        ScenarioError: it cannot be had, or is not what is expected; one line.
    """
    if isinstance(code, type):
        try:
            file = inspect.getsourcefile(code)
        except (TypeError, OSError):
            file = None
        if file is None or not file.endswith(".py"):
            raise ScenarioError(
                f"{kind}: expected a class in a file, which every process can read; {code.__name__} is in none "
                f"(write it to mine.py and name it mine.py:{code.__name__})"
            )
        code = f"{file}:{code.__qualname__}"
    if not names_code(code, kind):
        return code
    ensure_compiled(tell)
    return named(code, kind)


def tell(line: str) -> None:
    """A line for the user, apart from the results."""
    sys.stderr.write(f"echelon: {line}\n")
