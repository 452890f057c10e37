"""Options that several commands share."""

import argparse
import os
import sys
from pathlib import Path
from typing import Any

from cli.light_options import add_controllers
from formation.bodies.presets import PRESETS as BODIES
from formation.errors import EchelonError, ScenarioError
from formation.faults import PRESETS
from formation.loading.load import names_code
from formation.loading.source import Kind
from formation.scenario import files
from formation.scenario.overrides import at_path, from_settings, from_text, merged
from formation.scenario.places import overlapping
from formation.scenario.scenario import Scenario
from formation.units import seconds
from formation.validation import shown
from network.access.keys import LOCAL, OPEN, Keys, common_name, protocol
from network.arguments import INSECURE
from network.zenoh_bus import ZenohBus
from runtime.precompile import ensure_compiled
from runtime.record_keeper import file_name
from runtime.run_registry import find
from runtime.user_code import named

DEFAULT_SCENARIO = "triangle-circle"
CONNECT_SECONDS = 2.0
"""Longest wait for the router of a run [s]: it is there, or about to come back after it was killed."""


CONNECT, RUN, WITHOUT_KEYS, KEYS = "ECHELON_CONNECT", "ECHELON_RUN", "ECHELON_INSECURE", "ECHELON_KEYS"
"""Environment variables: the router and the name of the run that commands are for, --insecure, and a folder of keys."""


def add_scenario(parser: argparse.ArgumentParser, default: str = DEFAULT_SCENARIO) -> None:
    """The scenario, by default `default`, and its differences from the file."""
    parser.add_argument("scenario", nargs="?", default=default, help=f"name or TOML file (default: {default})")
    add_controllers(parser)
    parser.add_argument("--faults", metavar="PRESET|FILE", help=f"{', '.join(PRESETS)}, or a TOML file with [[faults]]")
    parser.add_argument("--bodies", metavar="PRESET|FILE.py:CLASS", help=f"{', '.join(BODIES)}, or bodies of your own")
    parser.add_argument("--seed", help="of noise and faults")
    parser.add_argument(
        "--set", action="append", default=[], metavar="KEY=VALUE", dest="settings", help="any key of the scenario"
    )


def controllers(options: argparse.Namespace) -> list[str]:
    """The names of --controller; code of a user's own is loaded. Raises ScenarioError."""
    return [_name("controller", spec) for spec in options.controller or ()]


def _name(kind: Kind, spec: str) -> str:
    """The name of what an option names; code of a user's own is loaded."""
    if not names_code(spec, kind):
        return spec
    ensure_compiled(tell)
    return named(spec, kind)


def add_record(parser: argparse.ArgumentParser) -> None:
    """Whether and where the run is recorded."""
    parser.add_argument(
        "--record",
        nargs="?",
        const="",
        metavar="FILE",
        help="record the run in a new MCAP file; --record alone names it after scenario and time",
    )
    parser.add_argument(
        "--detail", choices=["default", "full"], default="default", help="of the record; full: every plan and tick"
    )


def add_together(parser: argparse.ArgumentParser) -> None:
    """How many agents share a process."""
    parser.add_argument(
        "--together",
        type=int,
        metavar="N",
        help="agents in a process (default: 1; of many robots a process a core has as many as it takes)",
    )


def together(options: argparse.Namespace) -> int | None:
    """Agents in a process, if the user says so. Raises EchelonError."""
    wished: int | None = options.together
    if wished is not None and wished < 1:
        raise EchelonError(f"--together: expected 1 or more; got {wished}")
    return wished


def record_file(options: argparse.Namespace, name: str) -> Path | None:
    """The file to record in, None for none.

    Args:
        options: of `add_record`.
        name: of the scenario.

    Raises:
        EchelonError: the file exists, its folder does not, or it cannot be written there.
    """
    if options.record is None:
        return None
    file = Path(options.record or file_name(name)).absolute()
    try:
        file.open("xb").close()  # before the run: its recorder would record nothing
        file.unlink()
    except FileExistsError:
        raise EchelonError(f"--record: expected the name of a new file; {file} exists") from None
    except OSError as error:
        if isinstance(error, FileNotFoundError) and not file.parent.is_dir():
            raise EchelonError(f"--record: expected a file in a folder that exists; got {file}") from None
        raise EchelonError(f"--record: cannot write {file}: {error.strerror}") from None
    return file


def time(text: str) -> float:
    """A time as scenarios have it [s], for argparse. Raises argparse.ArgumentTypeError."""
    try:
        return float(seconds(text))  # type: ignore[arg-type]
    except ValueError as error:
        raise argparse.ArgumentTypeError(str(error)) from None


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


def overrides(options: argparse.Namespace) -> dict[str, Any]:
    """What differs from the scenario's file.

    Raises:
        ScenarioError: the preset or file of --faults does not exist, or a --set is not key=value.
    """
    found = from_settings(options.settings)
    wished = controllers(options)
    if wished:
        found = merged(found, at_path("controller.name", wished[0]))
    if options.bodies is not None:
        key = "bodies.implementation" if names_code(options.bodies, "bodies") else "bodies.preset"
        found = merged(found, at_path(key, _name("bodies", options.bodies)))
    if options.seed is not None:
        found = merged(found, at_path("seed", from_text(options.seed)))
    if options.faults is not None:
        found = merged(found, at_path("faults", _faults(options.faults)))
    return found


def _faults(name: str) -> list[dict[str, Any]]:
    """A value for the scenario's `faults`."""
    if name in PRESETS:
        return [{"preset": name}]
    if not files.is_file(name):
        choices = ", ".join([*PRESETS, "FILE.toml"])
        raise ScenarioError(f"--faults: expected one of {choices}; got {name!r}")
    entries = files.read(name).get("faults")
    if not isinstance(entries, list) or not all(isinstance(entry, dict) for entry in entries):
        got = "none" if entries is None else shown(entries)
        raise ScenarioError(f"--faults: expected [[faults]] tables in {name}; got {got}")
    return entries


def load(options: argparse.Namespace) -> tuple[Scenario, dict[str, Any]]:
    """The scenario, and the overrides that make it from its file. Raises ScenarioError."""
    changes = overrides(options)
    return files.load(options.scenario, changes), changes


def add_run(parser: argparse.ArgumentParser) -> None:
    """Which live run to connect to."""
    parser.add_argument("--run", metavar="NAME", help="the run (default: the only live one)")
    parser.add_argument("--connect", metavar="HOST[:PORT]", help="where it listens, if it is on another host")
    parser.add_argument("--code", help="for --connect the first time, as `echelon invite` printed it there")
    parser.add_argument("--insecure", action="store_true", help=f"for --connect tcp/HOST:PORT: {INSECURE}")


def session(options: argparse.Namespace, *, orders: bool = False) -> ZenohBus:
    """A session with the run that the options name, to give orders or only to listen. Raises EchelonError."""
    endpoint, insecure = options.connect, options.insecure
    if endpoint is None and options.run is None and CONNECT in os.environ:
        endpoint, insecure = os.environ[CONNECT], insecure or bool(os.environ.get(WITHOUT_KEYS))
        if KEYS in os.environ:
            keys = Keys.of(Path(os.environ[KEYS]), common_name("operator" if orders else "observer"))
            return ZenohBus(endpoint, os.environ.get(RUN) or "echelon", keys=keys, patience=CONNECT_SECONDS)
    if endpoint is not None and protocol(endpoint) in (*OPEN, LOCAL):
        run = options.run or os.environ.get(RUN) or "echelon"
        return ZenohBus(endpoint, run, insecure=insecure, patience=CONNECT_SECONDS)
    if endpoint is not None:
        from runtime.hosts.distant import connect  # noqa: PLC0415  cryptography costs other commands 0.1 s

        return connect(endpoint.removeprefix("tls/"), options.code, orders=orders, patience=CONNECT_SECONDS)
    found = find(options.run)
    return ZenohBus(found.endpoint, found.name, patience=CONNECT_SECONDS)


def tell(line: str) -> None:
    """Print a line for the user on stderr, apart from the results."""
    print(f"echelon: {line}", file=sys.stderr, flush=True)


def warn(scenario: Scenario) -> None:
    """Print a line on stderr if robots cannot follow what the scenario asks of them, or have no room there."""
    bodies = scenario.bodies
    if bodies.scaled != 1.0:
        tell(
            f"{scenario.name}: {bodies.preset} robots are {2.0 * bodies.radius:g} m wide: spacing, path and speed are "
            f"{bodies.scaled:.2g} times as large"
        )
    for line in (overlapping(scenario.formation, scenario.robots, bodies), scenario.feasibility().line):
        if line:
            tell(f"{scenario.name}: {line}")
