"""Imports between rooms point one way, and some modules are imported in one room only (docs/design.md, section 1)."""

import ast
import tomllib
from functools import cache
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).parent.parent
ALLOWED = {
    "formation": set(),
    "network": {"formation"},
    "agents": {"formation", "network"},
    "world": {"formation", "network"},
    "records": {"formation", "network"},
    "ros": {"formation", "network", "records"},
    "dashboard": {"formation", "network"},
    "runtime": {"formation", "network", "agents", "world", "records", "dashboard"},
    "experiments": {"formation", "network", "agents", "world", "records", "dashboard", "runtime"},
    "api": {"formation", "network", "agents", "world", "records", "dashboard", "runtime", "experiments"},
    "cli": {"formation", "network", "agents", "world", "records", "ros", "dashboard", "runtime", "experiments"},
}
"""Which rooms a room may import, besides itself."""
ROOMS = list(ALLOWED)
DATA = {"scenarios", "studies", "echelon.py", "echelon-stubs"}
"""Installed with the rooms, but not code of theirs."""
FILES = sorted(file for room in ROOMS for file in (ROOT / room).rglob("*.py"))
MAX_LINES = 300

MAX_MODULES = 20
"""In one folder, __init__ and __main__ aside."""

INSIDE: dict[str, list[set[str]]] = {
    "formation": [
        {"arrays", "errors", "units", "unicycle"},
        {"pattern", "validation", "loading"},
        {"shapes", "schema", "metrics"},
        {"link_ids"},
        {"formation_spec", "faults", "disturbances", "paths", "bodies"},
        {"clear"},
        {"offsets"},
        {"orientation"},
        {"slot_motion"},
        {"schedule"},
        {"reference", "feasibility"},
        {"way"},
        {"driving"},
        {"scenario"},
    ],
    "network": [
        {"fields", "inbox", "lifetime", "throttled_log", "run_folder"},
        {"values"},
        {"bodies", "stretch", "requests"},
        {"messages"},
        {"topics"},
        {"codec", "control", "link", "interventions"},
        {"bus", "access"},
        {"zenoh_bus", "memory_bus"},
        {"arguments"},
        {"health", "__main__"},
    ],
    "agents": [
        {"kernels", "states", "plausibility", "motor_model"},
        {"controllers"},
        {"belief", "driver_receiver", "estimator"},
        {"window_estimator", "plan_receiver", "sending", "avoidance"},
        {"agent"},
        {"node"},
        {"crew"},
        {"process", "several"},
        {"__main__"},
    ],
    "world": [
        {"bodies", "faults", "driver", "members", "states", "command_links"},
        {"measures", "rate", "sight", "interventions"},
        {"episode"},
        {"world"},
        {"presence", "journal", "samples"},
        {"run_control"},
        {"requests", "display"},
        {"parts", "real_robots"},
        {"node", "resume"},
        {"process"},
        {"__main__"},
    ],
    "records": [
        {"cdr", "definitions"},
        {"messages", "file", "scanning"},
        {"pictures"},
        {"recorder", "repair", "record"},
        {"export"},
        {"process"},
        {"__main__"},
    ],
    "ros": [
        {"types"},
        {"tokens", "decoding"},
        {"session", "spec"},
        {"survey", "connecting"},
        {"readiness", "body", "display"},
    ],
    "dashboard": [
        {"telemetry"},
        {"theme"},
        {"scene"},
        {"edits", "export", "keys", "notices", "pacing"},
        {"requests", "scenario_list"},
        {"panels"},
        {"steering"},
        {"overlay", "serving"},
        {"page"},
        {"__main__"},
    ],
    "experiments": [{"metrics"}, {"trials"}, {"report"}, {"study"}, {"errata"}, {"paper"}],
}
"""The order inside a room: a unit (a module, or a folder of them) imports its own row and those above it."""

WALL_CLOCK = {"time", "datetime", "sched", "calendar"}
CLOCKS = {
    "agents/process.py",
    "cli",
    "dashboard",
    "network/__main__.py",
    "network/bus.py",
    "network/inbox.py",
    "network/lifetime.py",
    "network/throttled_log.py",
    "records/process.py",
    "ros/body/process.py",
    "ros/display/process.py",
    "ros/readiness.py",
    "ros/session.py",
    "runtime",
    "world/process.py",
}
"""Who may read the wall clock: processes, and what paces or watches them. Everything else decides without it."""
CLOCK_FREE_RUNTIME = {"runtime/inprocess.py", "runtime/ghost/node.py", "runtime/ghost/shadow.py"}
"""Of the room that starts processes, the part that simulates without any."""
MEASURES_SOLVES = {
    place: {"perf_counter"} for place in ("agents/agent.py", "api/simulation.py", "runtime/inprocess.py")
}
"""How long something took may be measured; it decides nothing."""


def name_of(file: Path) -> str:
    return file.relative_to(ROOT).as_posix()


@cache
def imports(file: Path) -> list[tuple[str, set[str]]]:
    """Every (module, names imported from it), wherever it stands in the file."""
    found: list[tuple[str, set[str]]] = []
    for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            found += [(alias.name, set()) for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{name_of(file)}: relative import"
            found.append((node.module or "", {alias.name for alias in node.names}))
        elif isinstance(node, ast.Call) and isinstance(node.func, ast.Name | ast.Attribute):
            called = node.func.id if isinstance(node.func, ast.Name) else node.func.attr
            if called in ("import_module", "__import__") and node.args and isinstance(node.args[0], ast.Constant):
                found.append((str(node.args[0].value), set()))
    return found


def importers(package: str) -> set[str]:
    """Files that import a package or a part of it."""
    return {name_of(file) for file in FILES for module, _ in imports(file) if module.split(".")[0] == package}


def violations(file: Path) -> list[str]:
    room = name_of(file).split("/")[0]
    rooms = {module.split(".")[0] for module, _ in imports(file)} & set(ROOMS)
    return sorted(rooms - ALLOWED[room] - {room})


def test_there_is_something_to_check() -> None:
    assert len(FILES) > 50
    seen = {name_of(file).split("/")[0] for file in FILES}
    assert seen == set(ROOMS)
    assert sum(len(imports(file)) for file in FILES) > 300


@pytest.mark.parametrize("room", ROOMS)
def test_imports_between_rooms_point_one_way(room: Any) -> None:
    wrong = {name_of(file): violations(file) for file in FILES if name_of(file).startswith(f"{room}/")}
    assert wrong, f"no files in {room}"
    assert not {file: rooms for file, rooms in wrong.items() if rooms}


def test_the_rooms_that_must_not_know_each_other_do_not() -> None:
    assert not ALLOWED["dashboard"] & {"agents", "world"}
    assert "world" not in ALLOWED["agents"]
    assert "agents" not in ALLOWED["world"]
    order = {room: n for n, room in enumerate(ROOMS)}
    assert all(order[below] < order[room] for room, rooms in ALLOWED.items() for below in rooms)


def test_a_wrong_import_would_be_found(tmp_path: Any, monkeypatch: Any) -> None:
    monkeypatch.setattr(f"{__name__}.ROOT", tmp_path)
    (tmp_path / "agents").mkdir()
    file = tmp_path / "agents" / "bad.py"
    file.write_text(
        "def f():\n    from world.bodies.wheeled import WheeledBodies\n    import cli.main\n", encoding="utf-8"
    )
    assert violations(file) == ["cli", "world"]


def test_every_installed_package_is_a_room() -> None:
    with (ROOT / "pyproject.toml").open("rb") as file:
        packages = tomllib.load(file)["tool"]["hatch"]["build"]["targets"]["wheel"]["packages"]
    assert set(packages) - DATA == set(ROOMS)
    assert not [room for room in ROOMS if not (ROOT / room / "py.typed").is_file()]  # their types are installed too


def test_no_other_folder_holds_code_of_the_product() -> None:
    folders = {file.parent.name for file in ROOT.glob("*/*.py")}
    assert folders - set(ROOMS) <= {"tests", "benchmarks", "docs", "examples", ".ci"}


def test_zenoh_is_imported_where_a_session_is_made_only() -> None:
    """The run's, and those on other people's routers."""
    assert importers("zenoh") == {"network/zenoh_bus.py", "ros/session.py"}


def test_mcap_is_imported_in_records_only() -> None:
    files = importers("mcap")
    assert {file.split("/")[0] for file in files} == {"records"}


def test_viser_is_imported_in_dashboard_only() -> None:
    files = importers("viser")
    assert files
    assert {file.split("/")[0] for file in files} == {"dashboard"}


def test_numba_is_imported_where_kernels_are_compiled_only() -> None:
    # Importing numba costs a process 0.4 s and 120 MB: formation, network, world and dashboard must not.
    files = importers("numba")
    assert "agents/kernels/jit.py" in files
    assert {file.split("/")[0] for file in files} <= {"agents", "runtime", "cli"}


def test_keys_are_made_where_hosts_join_only() -> None:
    """Importing cryptography costs a process a tenth of a second, and a run on one host needs no keys."""
    assert importers("cryptography") == {"runtime/hosts/authority.py"}
    hosts = {name_of(file) for file in FILES for module, _ in imports(file) if module == "runtime.hosts.authority"}
    assert all(name.startswith("runtime/hosts/") for name in hosts)


def test_matplotlib_is_imported_in_experiments_only() -> None:
    files = importers("matplotlib")
    assert "experiments/report/style.py" in files
    assert {file.split("/")[0] for file in files} == {"experiments"}


def may_read_a_clock(file: Path) -> bool:
    name = name_of(file)
    return name not in CLOCK_FREE_RUNTIME and any(name == place or name.startswith(f"{place}/") for place in CLOCKS)


def test_only_processes_read_the_wall_clock() -> None:
    for file in FILES:
        used = [names for module, names in imports(file) if module.split(".")[0] in WALL_CLOCK]
        if name_of(file) in MEASURES_SOLVES:
            assert used == [MEASURES_SOLVES[name_of(file)]], name_of(file)
        elif not may_read_a_clock(file):
            assert not used, name_of(file)


def test_every_place_that_may_read_a_clock_exists_and_does() -> None:
    readers = {name_of(file) for file in FILES if any(m.split(".")[0] in WALL_CLOCK for m, _ in imports(file))}
    for place in CLOCKS:
        assert any(name == place or name.startswith(f"{place}/") for name in readers), place


def unit_of(name: str) -> str:
    """The unit of a module such as dashboard/panels/run.py: panels."""
    return name.split("/")[1].removesuffix(".py")


@pytest.mark.parametrize("room", INSIDE)
def test_arrows_inside_a_room_point_one_way(room: Any) -> None:
    rank = {unit: row for row, units in enumerate(INSIDE[room]) for unit in units}
    files = [file for file in FILES if name_of(file).startswith(f"{room}/") and name_of(file) != f"{room}/__init__.py"]
    assert {unit_of(name_of(file)) for file in files} == set(rank)
    wrong = []
    for file in files:
        own = rank[unit_of(name_of(file))]
        for module, names in imports(file):
            parts = module.split(".")
            if parts[0] != room:
                continue
            units = {parts[1]} if len(parts) > 1 else names
            wrong += [f"{name_of(file)} imports {unit}" for unit in units if rank[unit] > own]
    assert not wrong


def test_a_folder_has_at_most_20_modules() -> None:
    folders = {file.parent for file in FILES}
    assert len(folders) > 15
    for folder in folders:
        modules = [file for file in folder.glob("*.py") if not file.stem.startswith("__")]
        assert len(modules) <= MAX_MODULES, folder


def test_chance_in_the_core_is_seeded() -> None:
    """No module of `random`, and no numpy generator without a seed, in what decides."""
    files = [file for file in FILES if not may_read_a_clock(file)]
    assert len(files) > 25
    for file in files:
        assert "random" not in {module for module, _ in imports(file)}, name_of(file)
        text = file.read_text(encoding="utf-8")
        assert "default_rng()" not in text, name_of(file)
        assert "np.random.seed" not in text, name_of(file)


@pytest.mark.parametrize("file", FILES, ids=name_of)
def test_a_file_has_at_most_300_lines_and_a_docstring(file: Any) -> None:
    text = file.read_text(encoding="utf-8")
    assert len(text.splitlines()) <= MAX_LINES
    assert ast.get_docstring(ast.parse(text)), "no docstring"


@pytest.mark.parametrize("room", ROOMS)
def test_a_rooms_init_is_one_docstring(room: Any) -> None:
    body = ast.parse((ROOT / room / "__init__.py").read_text(encoding="utf-8")).body
    assert len(body) == 1
    assert isinstance(body[0], ast.Expr)


def test_there_are_no_utils_and_no_common() -> None:
    assert not [file for file in FILES if file.stem in {"utils", "util", "common", "helpers", "misc"}]


def test_tests_mirror_the_tree() -> None:
    """A folder of tests is a folder of the product, or starts browsers or processes."""
    for file in (ROOT / "tests").rglob("test_*.py"):
        folder = file.parent.relative_to(ROOT / "tests").as_posix()
        assert folder in {".", "browser", "processes"} or (ROOT / folder / "__init__.py").exists(), folder
    assert not list((ROOT / "tests").rglob("__init__.py"))  # a package `tests.agents` would shadow nothing, but confuse
