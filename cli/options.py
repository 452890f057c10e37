"""Options that several commands share."""

import argparse
import sys
import tomllib
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from experiments.trials.overrides import at_path, merged
from formation.errors import EchelonError, ScenarioError
from formation.faults import PRESETS
from formation.scenario import files
from formation.scenario.registry import NAMES
from formation.scenario.scenario import Scenario
from network.zenoh_bus import Session
from runtime.run_registry import find

DEFAULT_SCENARIO = "triangle-circle"


def add_scenario(parser: argparse.ArgumentParser) -> None:
    """The scenario, and its differences from the file."""
    parser.add_argument(
        "scenario", nargs="?", default=DEFAULT_SCENARIO, help=f"name or TOML file (default: {DEFAULT_SCENARIO})"
    )
    parser.add_argument("--controller", help=", ".join(NAMES))
    parser.add_argument("--faults", metavar="PRESET|FILE", help=f"{', '.join(PRESETS)}, or a TOML file with [[faults]]")
    parser.add_argument("--seed", help="of noise and faults")
    parser.add_argument(
        "--set", action="append", default=[], metavar="KEY=VALUE", dest="settings", help="any key of the scenario"
    )


def add_workers(parser: argparse.ArgumentParser) -> None:
    """Where trials are simulated."""
    parser.add_argument("--workers", type=int, metavar="N", help="processes (default: one per core)")
    parser.add_argument("--cluster", metavar="ADDRESS", help="simulate on the Dask cluster of this scheduler")


def check_workers(options: argparse.Namespace) -> None:
    """Refuse what makes no sense of `add_workers`. Raises EchelonError."""
    if options.workers is not None and options.workers < 1:
        raise EchelonError(f"--workers: expected at least 1; got {options.workers}")
    if options.workers is not None and options.cluster is not None:
        raise EchelonError("--workers: expected no number with --cluster; the cluster has its own")


def nested(changes: Iterable[str]) -> dict[str, Any]:
    """Overrides as nested data from KEY=VALUE; a value that is not TOML is text.

    Raises:
        ScenarioError: one is not KEY=VALUE.
    """
    found: dict[str, Any] = {}
    for change in changes:
        key, equals, text = change.partition("=")
        if not equals or not key.strip():
            raise ScenarioError(f"--set: expected key=value; got {change!r}")
        try:
            value = tomllib.loads(f"value = {text}")["value"]
        except (tomllib.TOMLDecodeError, RecursionError):
            value = text.strip()
        found = merged(found, at_path(key, value))
    return found


def settings(options: argparse.Namespace) -> list[str]:
    """The scenario's changes as key=value.

    Raises:
        ScenarioError: the preset or file of --faults does not exist.
    """
    found = list(options.settings)
    if options.controller is not None:
        found.append(f"controller.name={options.controller}")
    if options.seed is not None:
        found.append(f"seed={options.seed}")
    if options.faults is not None:
        found.append(f"faults={_faults(options.faults)}")
    return found


def _faults(name: str) -> str:
    """A TOML value for the scenario's `faults`."""
    if name in PRESETS:
        return f'[{{ preset = "{name}" }}]'
    if not name.endswith(".toml"):
        choices = ", ".join([*PRESETS, "FILE.toml"])
        raise ScenarioError(f"--faults: expected one of {choices}; got {name!r}")
    entries = files.read(name).get("faults")
    if not isinstance(entries, list) or not all(isinstance(entry, dict) for entry in entries):
        raise ScenarioError(f"--faults: expected [[faults]] tables in {name}; got {entries!r:.60}")
    tables = [", ".join(f"{key} = {_value(value)}" for key, value in entry.items()) for entry in entries]
    return "[" + ", ".join(f"{{ {table} }}" for table in tables) + "]"


def _value(value: object) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    return repr(value) if isinstance(value, int | float) else '"' + str(value).replace('"', "") + '"'


def load(options: argparse.Namespace) -> tuple[Scenario, list[str]]:
    """The scenario, and the key=value settings that make it from its file. Raises ScenarioError."""
    changes = settings(options)
    return files.load(options.scenario, changes), changes


def source(options: argparse.Namespace) -> str:
    """The scenario's name, or the absolute path of its file."""
    name: str = options.scenario
    return str(Path(name).resolve()) if name.endswith(".toml") or "/" in name else name


def add_run(parser: argparse.ArgumentParser) -> None:
    """Which live run to connect to."""
    parser.add_argument("--run", metavar="NAME", help="the run (default: the only live one)")
    parser.add_argument("--connect", metavar="ENDPOINT", help="its router, if it is not on this machine")


def session(options: argparse.Namespace) -> Session:
    """A session with the run that the options name. Raises EchelonError."""
    if options.connect is not None:
        return Session(options.connect, options.run or "echelon")
    run = find(options.run)
    return Session(run.endpoint, run.name)


def tell(line: str) -> None:
    """Print a line for the user on stderr, apart from the results."""
    print(f"echelon: {line}", file=sys.stderr, flush=True)
