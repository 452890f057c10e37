"""Scenarios from files: by name or path, with settings applied, every mistake in a line of its own."""

import copy
import tomllib
from collections.abc import Iterable
from pathlib import Path as File
from typing import Any

from pydantic import ValidationError

from formation.errors import ScenarioError, unknown
from formation.scenario.scenario import Scenario
from formation.validation import problems

SHIPPED = File(__file__).parents[2] / "scenarios"


def shipped() -> list[str]:
    """Names of the scenarios that come with the project."""
    return sorted(file.stem for file in SHIPPED.glob("*.toml"))


def load(name: str, settings: Iterable[str] = ()) -> Scenario:
    """A scenario by its name or its TOML file, with `key=value` settings applied.

    Raises:
        ScenarioError: it does not exist or is wrong; one line per mistake.
    """
    return parse(read(name), settings, where=name)


def read(name: str) -> dict[str, Any]:
    """The raw table of a scenario by its name or its TOML file.

    Raises:
        ScenarioError: there is no such scenario, or it is not TOML.
    """
    file = File(name) if name.endswith(".toml") or "/" in name else SHIPPED / f"{name}.toml"
    try:
        return tomllib.loads(file.read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise ScenarioError(unknown("scenario", name, [*shipped(), "FILE.toml"])) from None
    except (OSError, UnicodeDecodeError) as error:
        raise ScenarioError(f"{name}: cannot be read: {error}") from None
    except (tomllib.TOMLDecodeError, RecursionError) as error:
        raise ScenarioError(f"{name}: expected TOML; {error}") from None


def parse(raw: dict[str, Any], settings: Iterable[str] = (), *, where: str = "scenario") -> Scenario:
    """A scenario from its raw table.

    Raises:
        ScenarioError: one line per mistake.
    """
    raw = copy.deepcopy(raw)
    for setting in settings:
        _apply(raw, setting)
    try:
        return Scenario.model_validate(raw)
    except ValidationError as error:
        lines = [line.removeprefix("file: ") for line in problems(error, Scenario)]
        raise ScenarioError("\n".join(f"{where}: {line}" for line in lines)) from None


def _apply(raw: dict[str, Any], setting: str) -> None:
    key, equals, text = setting.partition("=")
    if not equals or not key.strip():
        raise ScenarioError(f"--set: expected key=value; got {setting!r}")
    try:
        value = tomllib.loads(f"value = {text}")["value"]
    except (tomllib.TOMLDecodeError, RecursionError):
        value = text.strip()
    *parents, last = key.strip().split(".")
    table = raw
    for parent in parents:
        table = table.setdefault(parent, {})
        if not isinstance(table, dict):
            raise ScenarioError(f"--set {key.strip()}: expected the path of a key; {parent} is not a table")
    table[last] = value
