"""Scenarios by name, file or value, with nested overrides and code of the caller's own."""

import inspect
import os
import sys
from collections.abc import Mapping
from typing import Any

from formation.errors import ScenarioError
from formation.loading.load import names_code
from formation.scenario import files
from formation.scenario.overrides import at_path, merged
from formation.scenario.scenario import Scenario
from formation.validation import shown
from runtime.precompile import ensure_compiled
from runtime.user_code import named

_loading: set[str] = set()
"""Code of callers' own that is being loaded now."""


def load(
    scenario: str | os.PathLike[str] | Scenario = "triangle-circle",
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
    if not isinstance(scenario, str | os.PathLike | Scenario):
        raise ScenarioError(
            f"scenario: expected a name, a TOML file or a Scenario; got {shown(scenario)} (nested data comes second, "
            "as overrides)"
        )
    changes = table_of(overrides)
    if isinstance(changes.get("bodies"), str):
        changes["bodies"] = {"preset": changes["bodies"]}
    if controller is not None:
        changes = merged(changes, at_path("controller.name", name_of(controller, "controller")))
    if bodies is not None:
        preset = isinstance(bodies, str) and not names_code(bodies, "bodies")
        key = "bodies.preset" if preset else "bodies.implementation"
        changes = merged(changes, at_path(key, bodies if preset else name_of(bodies, "bodies")))
    if isinstance(scenario, Scenario):
        return files.parse(scenario.model_dump(mode="json", exclude_unset=True), changes, where=scenario.name)
    return files.load(os.fspath(scenario), changes)


def table_of(overrides: object) -> dict[str, Any]:
    """Nested data as a table of its own. Raises ScenarioError: it is none."""
    if overrides is None:
        return {}
    if not isinstance(overrides, Mapping):
        raise ScenarioError(
            f'overrides: expected nested data such as {{"link": {{"latency": 0.3}}}}; got {shown(overrides)}'
        )
    return dict(overrides)


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
    if not isinstance(code, str):
        raise ScenarioError(f"{kind}: expected a name, FILE.py:CLASS or a class; got {shown(code)}")
    if not names_code(code, kind):
        return code
    if code in _loading:
        raise ScenarioError(
            f'{kind}: expected a file that does its work below `if __name__ == "__main__":`; {code} loads itself'
        )
    ensure_compiled(tell)
    _loading.add(code)
    try:
        return named(code, kind)
    finally:
        _loading.discard(code)


def tell(line: str) -> None:
    """A line for the user, apart from the results."""
    sys.stderr.write(f"echelon: {line}\n")
