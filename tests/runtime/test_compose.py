"""Laws of compose.yaml: it is what the generator gives, holds the launcher's own processes, and opens nothing more."""

import json
import re
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import pytest
import yaml

from agents.controllers.own import load_controller
from formation.errors import ScenarioError
from formation.loading.source import LOADED, Source
from formation.scenario.files import load, shipped
from formation.scenario.overrides import Overrides, from_json
from runtime.compose import ISSUING, KEYS, PAGE_PORT, ROUTER_PORT, RUN, SAVED, compose_file, plan, service_name
from runtime.process_list import RunPlan, programs
from tests.user_code import clean, hold_slot

__all__ = ["clean", "hold_slot"]
Write = Callable[..., str]
ROOT = Path(__file__).parents[2]
SCENARIO = "triangle-circle"


class Loader(yaml.SafeLoader):  # type: ignore[misc]  # PyYAML has no types
    """Refuses a key that stands twice in one map, as compose does and PyYAML does not."""

    def construct_mapping(self, node: yaml.MappingNode, deep: bool = False) -> dict[Any, Any]:
        own = [key.value for key, _ in node.value if key.value != "<<"]
        assert len(own) == len(set(own)), f"twice in one map: {own}"
        mapping: dict[Any, Any] = super().construct_mapping(node, deep)
        return mapping


def parsed(text: str) -> dict[str, Any]:
    """The file as compose reads it."""
    found: dict[str, Any] = yaml.load(text, Loader)
    return found


def all_services(scenario: str = SCENARIO, overrides: Overrides | None = None) -> dict[str, Any]:
    found: dict[str, Any] = parsed(compose_file(scenario, load(scenario, overrides or {}), overrides))["services"]
    return found


def services(scenario: str = SCENARIO, overrides: Overrides | None = None) -> dict[str, Any]:
    """Those that are processes of the run."""
    return {name: made for name, made in all_services(scenario, overrides).items() if name != "keys"}


def without(arguments: Sequence[str], *flags: str) -> list[str]:
    """The arguments without these flags and their values."""
    left = list(arguments)
    for flag in flags:
        if flag in left:
            at = left.index(flag)
            del left[at : at + 2]
    return left


def test_a_key_that_stands_twice_is_found() -> None:
    assert parsed("x: &s {a: 1}\ny: {<<: *s, b: 2}") == {"x": {"a": 1}, "y": {"a": 1, "b": 2}}
    with pytest.raises(AssertionError, match="twice"):
        parsed("x: {a: 1, a: 2}")


def test_the_file_is_what_the_generator_gives() -> None:
    assert (ROOT / "compose.yaml").read_text() == compose_file(SCENARIO, load(SCENARIO))


@pytest.mark.parametrize("scenario", shipped())
def test_one_service_per_program(scenario: str) -> None:
    expected = {
        service_name(program): ["python", "-m", program.module, *program.arguments]
        for program in programs(plan(scenario, {}), load(scenario))
    }
    assert {name: service["command"] for name, service in services(scenario).items()} == expected


def test_overrides_reach_the_world_and_nobody_else_counts_robots() -> None:
    overrides = {"formation": {"robots": 5}, "controller": {"name": "paper"}, "source": 'it\'s a "test" of $HOME'}
    found = services("ring-16", overrides)
    assert found["agents"] == services()["agents"]
    command = found["world"]["command"]
    text = command[command.index("--overrides") + 1].replace("$$", "$")  # as compose reads it
    assert from_json(text) == overrides


def test_the_same_processes_as_the_launcher_starts() -> None:
    """Only where they meet differs, and that one process keeps all agents, as many as the world then has."""
    socket, page = "unixsock-stream/S", ("127.0.0.1", PAGE_PORT)
    here = RunPlan(RUN, SCENARIO, socket, (socket,), endless=True, folder="F", dashboard=page, ghost=True)
    places = ("--connect", "--listen", "--folder", "--host", "--keys", "--scenario")
    launched = {
        program.name: ["python", "-m", program.module, *without(program.arguments, *places)]
        for program in programs(here, load(SCENARIO))
    }
    agents = {name: launched.pop(name) for name in [*launched] if name.startswith("agent ")}
    composed = {name: without(service["command"], *places) for name, service in services().items()}
    kept = composed.pop("agents")
    assert composed == launched
    for command in agents.values():
        assert without(command[3:], "--id") == kept[3:]


def test_the_scenario_is_that_of_the_environment_and_nothing_else_is() -> None:
    text = compose_file(SCENARIO, load(SCENARIO), {"source": "$HOME"}, record=True)
    variables = re.findall(r"\$\{[^}]*\}|\$", text.split("services:", 1)[1].replace("$$", ""))
    assert variables == [f"${{SCENARIO:-{SCENARIO}}}"] * 2  # of the world, and in the record's name


def test_commands_in_any_container_are_for_its_run() -> None:
    expected = {"ECHELON_CONNECT": f"tls/router:{ROUTER_PORT}", "ECHELON_RUN": RUN}
    expected |= {"ECHELON_KEYS": KEYS, "ECHELON_IN_CONTAINER": "1"}
    assert all(service["environment"] == expected for service in services().values())


def test_the_world_saves_the_run_where_only_its_own_container_keeps_it() -> None:
    found = services()
    assert [name for name, service in found.items() if SAVED in service["command"]] == ["world"]
    assert re.search(rf"mkdir .*{SAVED} .*&& chown 10001:10001 .*{SAVED} ", (ROOT / "Dockerfile").read_text())
    assert found["world"]["volumes"] == [f"keys:{KEYS}:ro"]  # with another, the next run would go on from this one


def test_everybody_meets_at_the_router() -> None:
    for name, service in services().items():
        flag = "--listen" if name == "router" else "--connect"
        where = service["command"][service["command"].index(flag) + 1]
        assert where == f"tls/{'0.0.0.0' if name == 'router' else 'router'}:{ROUTER_PORT}"
        first = {"keys": {"condition": "service_completed_successfully"}}
        assert service["depends_on"] == (first if name == "router" else ["router"])


def test_keys_are_made_before_all_else_where_only_services_of_the_run_see_them() -> None:
    found = all_services()
    assert (found["keys"]["command"], found["keys"]["volumes"]) == ([*ISSUING], [f"keys:{KEYS}"])
    assert all(service["volumes"] == [f"keys:{KEYS}:ro"] for name, service in found.items() if name != "keys")
    assert parsed(compose_file(SCENARIO, load(SCENARIO)))["volumes"] == {"keys": {}}
    assert f"chmod 700 {KEYS}" in (ROOT / "Dockerfile").read_text()


def test_only_the_page_is_published_and_only_on_loopback() -> None:
    found = services()
    assert {name: service["ports"] for name, service in found.items() if "ports" in service} == {
        "dashboard": [f"127.0.0.1:{PAGE_PORT}:{PAGE_PORT}"]
    }
    assert all(service["networks"] == ["formation"] for service in found.values())
    doors = {"network_mode", "expose", "privileged", "cap_add", "devices", "pid", "ipc"}
    assert not any(doors & set(service) for service in found.values())


def test_no_service_can_do_more_than_it_must() -> None:
    for name, service in all_services().items():
        assert service["user"] == "10001:10001"
        assert service["read_only"] is (name != "world")  # which saves the run
        assert service["cap_drop"] == ["ALL"]
        assert service["security_opt"] == ["no-new-privileges:true"]
        assert service["tmpfs"] == ["/tmp:mode=1777"]
        assert service["restart"] == "on-failure"  # `echelon control stop` ends the world for good


def test_every_service_is_checked_as_what_it_is() -> None:
    for program in programs(plan(SCENARIO, {}), load(SCENARIO)):
        check = services()[service_name(program)]["healthcheck"]
        where = ["--run", RUN, "--connect", f"tls/router:{ROUTER_PORT}", "--keys", KEYS]
        who = ["--role", program.role]
        assert check["test"] == ["CMD", "python", "-m", "network.health", *where, *who]


def test_one_service_builds_the_image_that_all_use() -> None:
    found = services()
    assert {name: service["build"] for name, service in found.items() if "build" in service} == {"router": "."}
    assert {service["image"] for service in found.values()} == {"localhost/echelon"}
    assert {service["pull_policy"] for service in found.values()} == {"never"}


def test_the_image_holds_every_package_and_compiles_from_the_installed_ones() -> None:
    """Kernels are compiled from the packages that containers run, not from the copied folders."""
    lines = (ROOT / "Dockerfile").read_text().splitlines()
    copied = {line.split()[1] for line in lines if re.fullmatch(r"COPY (\S+) \1", line)}
    packages = re.search(r"^packages = (\[.*\])$", (ROOT / "pyproject.toml").read_text(), re.MULTILINE)
    assert packages is not None
    assert copied == set(json.loads(packages[1]))
    compiling = next(i for i, line in enumerate(lines) if "ensure_compiled" in line)
    folder = [line for line in lines[:compiling] if line.startswith("WORKDIR ")][-1]
    assert folder == "WORKDIR /tmp"
    assert lines[-1] == "USER 10001:10001"


def test_a_changed_line_downloads_nothing_and_compiles_nothing() -> None:
    """Dependencies are a layer before the first source; the solver's compilation has a cache of its own."""
    text = (ROOT / "Dockerfile").read_text()
    steps = ["pip install --no-cache-dir -c constraints.txt -r", "COPY formation", "--no-deps", "--mount=type=cache"]
    places = [text.index(step) for step in steps]
    assert places == sorted(places)


def test_the_folder_of_code_of_ones_own_is_mounted_where_it_is_loaded(hold_slot: Write) -> None:
    spec = hold_slot()
    name = load_controller(spec).name
    overrides = {"controller": {"name": name}}
    found = services(SCENARIO, overrides)
    folder = spec.rpartition("/")[0]
    for service, made in found.items():
        loads = service in ("agents", "ghost")
        assert (len(made["volumes"]) == 2) == loads, service
        if loads:
            _, volume = made["volumes"]
            assert (volume["source"], volume["read_only"]) == (folder, True)
            assert f"{volume['target']}/mine.py:HoldSlot" in made["command"]
        assert ("--controllers" in made["command"]) == (service == "world")


def test_an_installed_module_is_refused_for_the_image_does_not_have_it(tmp_path: Path, clean: None) -> None:
    LOADED["controller", "X"] = Source("controller", "X", "package.module", "X", {}, "0" * 64)
    with pytest.raises(ScenarioError, match=r"expected FILE.py:CLASS.*got package.module:X"):
        compose_file(SCENARIO, load(SCENARIO))


def test_a_run_that_is_recorded_has_one_more_service_with_a_volume() -> None:
    text = compose_file(SCENARIO, load(SCENARIO), record=True, realtime=True)
    found = parsed(text)
    assert [name for name, made in found["services"].items() if "--realtime" in made["command"]] == ["world"]
    assert found["services"].keys() - all_services().keys() == {"recorder"}
    assert found["services"]["recorder"]["volumes"] == [f"keys:{KEYS}:ro", "records:/records"]
    assert found["volumes"] == {"keys": {}, "records": {}}
    assert "chown 10001:10001 /records" in (ROOT / "Dockerfile").read_text()
