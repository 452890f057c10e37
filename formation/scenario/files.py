"""Scenarios from files: by name or path, with overrides, every mistake in a line of its own."""

import tomllib
from collections.abc import Iterable, Mapping
from pathlib import Path as File
from typing import Any

from pydantic import ValidationError

from formation.errors import ScenarioError, unknown
from formation.scenario.overrides import Overrides, from_settings, merged
from formation.scenario.scenario import Scenario
from formation.validation import problems

SHIPPED = File(__file__).parents[2] / "scenarios"


def shipped() -> list[str]:
    """Names of the scenarios that come with the project."""
    return sorted(file.stem for file in SHIPPED.glob("*.toml"))


def load(name: str, overrides: Overrides | Iterable[str] = ()) -> Scenario:
    """A scenario by its name or its TOML file, with overrides such as {"link": {"latency": 0.3}}.

    Raises:
        ScenarioError: it does not exist or is wrong; one line per mistake.
    """
    return parse(read(name), overrides, where=name)


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


def parse(raw: Overrides, overrides: Overrides | Iterable[str] = (), *, where: str = "scenario") -> Scenario:
    """A scenario from its raw table, with overrides: nested, or settings such as link.latency=0.3.

    Raises:
        ScenarioError: one line per mistake.
    """
    if not isinstance(overrides, Mapping):
        overrides = from_settings(overrides)
    try:
        return Scenario.model_validate(merged(raw, overrides))
    except ValidationError as error:
        lines = [line.removeprefix("file: ") for line in problems(error, Scenario)]
        raise ScenarioError("\n".join(f"{where}: {line}" for line in lines)) from None
