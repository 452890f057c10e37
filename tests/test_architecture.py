"""The arrows between the rooms point one way, and some words are spoken in one room only (DESIGN sections 1 and 8)."""

import ast
import importlib
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
    "dashboard": {"formation", "network"},
    "fleet": {"formation", "network", "agents", "world", "dashboard"},
    "experiments": {"formation", "network", "agents", "world", "dashboard", "fleet"},
    "cli": {"formation", "network", "agents", "world", "dashboard", "fleet", "experiments"},
}
"""Which rooms a room may import, besides itself."""
ROOMS = list(ALLOWED)
DATA = {"scenarios", "studies"}
"""Installed with the rooms, but not code of theirs."""
FILES = sorted(file for room in ROOMS for file in (ROOT / room).rglob("*.py"))
MAX_LINES = 300

WALL_CLOCK = {"time", "datetime", "sched", "calendar"}
CLOCK_FREE = [
    "formation",
    "agents/agent.py",
    "agents/belief.py",
    "agents/box_kernel.py",
    "agents/centralised.py",
    "agents/consensus.py",
    "agents/consensus_kernel.py",
    "agents/controllers.py",
    "agents/kernels.py",
    "agents/leader_follower.py",
    "agents/matrix_kernels.py",
    "agents/nash.py",
    "agents/nash_kernel.py",
    "agents/paper.py",
    "agents/paper_game_kernel.py",
    "agents/paper_kernel.py",
    "agents/situation.py",
    "agents/team_kernel.py",
    "agents/virtual_structure.py",
    "network/codec.py",
    "network/control.py",
    "network/keys.py",
    "network/link.py",
    "network/messages.py",
    "world/faults.py",
    "world/plant.py",
    "world/trace.py",
    "world/world.py",
    "fleet/inprocess.py",
    "fleet/ghost/shadow.py",
    "experiments",
]
"""The core: what decides reads no clock. Everything else in these rooms is the shell of a process."""
MEASURES_SOLVES = {"agents/agent.py": {"perf_counter"}, "fleet/inprocess.py": {"perf_counter"}}
"""How long something took may be measured; it decides nothing."""
PURE = [name for name in CLOCK_FREE if name not in MEASURES_SOLVES]
SHELLS_WITH_CLOCKS = {"agents", "world", "dashboard", "network", "fleet", "cli"}


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
    file.write_text("def f():\n    from world.plant import Plant\n    import cli.main\n", encoding="utf-8")
    assert violations(file) == ["cli", "world"]


def test_every_installed_package_is_a_room() -> None:
    with (ROOT / "pyproject.toml").open("rb") as file:
        packages = tomllib.load(file)["tool"]["hatch"]["build"]["targets"]["wheel"]["packages"]
    assert set(packages) - DATA == set(ROOMS)


def test_no_other_folder_holds_code_of_the_product() -> None:
    folders = {file.parent.name for file in ROOT.glob("*/*.py")}
    assert folders - set(ROOMS) <= {"tests", "benchmarks", "docs", ".ci"}


def test_zenoh_is_imported_in_one_module_of_network() -> None:
    assert importers("zenoh") == {"network/session.py"}


def test_viser_is_imported_in_dashboard_only() -> None:
    files = importers("viser")
    assert files
    assert {file.split("/")[0] for file in files} == {"dashboard"}


def test_numba_is_imported_where_kernels_are_compiled_only() -> None:
    # Importing numba costs a process 0.4 s and 120 MB: formation, network, world and dashboard must not.
    files = importers("numba")
    assert "agents/compiled.py" in files
    assert {file.split("/")[0] for file in files} <= {"agents", "fleet", "cli"}


def test_matplotlib_is_imported_in_experiments_only() -> None:
    files = importers("matplotlib")
    assert "experiments/style.py" in files
    assert {file.split("/")[0] for file in files} == {"experiments"}


@pytest.mark.parametrize("place", PURE)
def test_what_decides_reads_no_wall_clock(place: Any) -> None:
    files = [file for file in FILES if name_of(file) == place or name_of(file).startswith(f"{place}/")]
    assert files, f"{place} does not exist"
    for file in files:
        modules = {module.split(".")[0] for module, _ in imports(file)}
        assert not modules & WALL_CLOCK, name_of(file)


def test_solve_times_are_measured_with_perf_counter_and_nothing_else() -> None:
    for place, allowed in MEASURES_SOLVES.items():
        used = [names for module, names in imports(ROOT / place) if module.split(".")[0] in WALL_CLOCK]
        assert used == [allowed], place


def test_only_shells_of_processes_read_a_clock() -> None:
    readers = importers("time") | importers("datetime")
    assert readers
    assert {file.split("/")[0] for file in readers} <= SHELLS_WITH_CLOCKS
    shells = {file for file in readers if file.split("/")[0] in {"agents", "world", "network"}} - set(MEASURES_SOLVES)
    processes = {"agents/process.py", "world/process.py", "world/pace.py", "world/roster.py"}
    # In network: the end of a process, the log's rate, the router's health, and waiting for replies.
    network = {
        "network/lifetime.py",
        "network/rejects.py",
        "network/health.py",
        "network/session.py",
        "network/__main__.py",
    }
    assert shells <= processes | network


def test_chance_in_the_core_is_seeded() -> None:
    """No module of `random`, and no numpy generator without a seed, in what decides."""
    files = [file for file in FILES if any(name_of(file).startswith(place) for place in CLOCK_FREE)]
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


def test_tests_are_flat_and_shadow_no_room() -> None:
    folders = {
        path.name for path in (ROOT / "tests").iterdir() if path.is_dir() and not path.name.startswith((".", "__"))
    }
    assert folders <= {"browser", "processes"}
    for room in ROOMS:
        origin = importlib.import_module(room).__file__
        assert origin is not None
        assert Path(origin).parent == ROOT / room
