"""The same processes as containers: a compose file made of runtime/process_list.py."""

import json
from collections.abc import Mapping, Sequence

from formation.loading.source import LOADED
from formation.scenario.overrides import Overrides, to_json
from formation.scenario.registry import check_live
from formation.scenario.scenario import Scenario
from runtime.process_list import Program, RunPlan, programs
from runtime.user_code import NO_CODE, CodeArguments, mounted

RUN = "echelon"
ROUTER_PORT = 7447
PAGE_PORT = 8090
SAVED = "/var/lib/echelon"
"""Where the world saves the run, in its own container; the image has the folder with the right owner."""
RECORDS = "/records"
"""Where records are, in a volume of the same name; the image has the folder with the right owner."""

_HEAD = """\
# Made by `echelon compose {words}`: router, world, one service per robot, ghost, dashboard.
# `docker compose up --build`, then open http://127.0.0.1:{port}. Only that port is published, on loopback.
name: echelon

x-service: &service
  image: localhost/echelon
  pull_policy: never
  user: "10001:10001"
  read_only: true
  cap_drop: [ALL]
  security_opt: ["no-new-privileges:true"]
  tmpfs: ["/tmp:mode=1777"]
  restart: on-failure
  networks: [formation]
  environment:
    ECHELON_CONNECT: "tcp/router:{router}"  # `docker compose exec world echelon status` needs no options
    ECHELON_RUN: "{run}"
    ECHELON_INSECURE: "1"  # inside the network of these containers only
    ECHELON_IN_CONTAINER: "1"

networks:
  formation: {{}}

services:
"""


def plan(scenario: str, overrides: Overrides, code: CodeArguments = NO_CODE, *, record: bool = False) -> RunPlan:
    """How a run of containers is put together."""
    return RunPlan(
        run=RUN,
        scenario=scenario,
        connect=f"tcp/router:{ROUTER_PORT}",
        listen=(f"tcp/0.0.0.0:{ROUTER_PORT}",),
        insecure=True,  # nobody but the services reaches their network
        overrides=overrides,
        endless=True,
        ghost=True,
        folder=SAVED,
        containers=True,
        code=code,
        dashboard=("0.0.0.0", PAGE_PORT),  # of its container; published on loopback only
        record=f"{RECORDS}/{scenario}.mcap" if record else None,
    )


def compose_file(name: str, scenario: Scenario, overrides: Overrides | None = None, *, record: bool = False) -> str:
    """The text of a compose file that runs the scenario.

    Args:
        name: of a shipped scenario: the image holds no others.
        scenario: the same, loaded.
        overrides: what differs from it.
        record: whether the run is recorded, in a volume.

    Raises:
        ScenarioError: its controller cannot run as processes.
    """
    check_live(scenario.controller.name)
    words = " ".join([name, *([f"with {to_json(overrides)}"] if overrides else [])])
    head = _HEAD.format(words=words, port=PAGE_PORT, router=ROUTER_PORT, run=RUN)
    code, mounts = mounted(LOADED.values())
    listed = programs(plan(name, overrides or {}, code, record=record), scenario)
    services = "\n".join(_service(program, mounts) for program in listed)
    return head + services + ("\nvolumes:\n  records: {}\n" if record else "")


def _service(program: Program, mounts: Mapping[str, str]) -> str:
    name = f"agent-{program.number}" if program.role == "agent" else program.role
    check = [
        "CMD",
        "python",
        "-m",
        "network.health",
        "--run",
        RUN,
        "--connect",
        f"tcp/router:{ROUTER_PORT}",
        "--insecure",
    ]
    check += ["--role", program.role, "--id", str(program.number)]
    lines = [
        f"  {name}:",
        "    <<: *service",
        *(["    build: ."] if program.role == "router" else []),
        f"    command: {_words(['python', '-m', program.module, *program.arguments])}",
        "    healthcheck:",
        f"      test: {_words(check)}",
        "      interval: 2m",
        "      timeout: 8s",
        "      start_period: 30s",
        "      start_interval: 2s",
    ]
    if program.role == "world":  # it saves the run: what it writes outlives its process, and goes with its container
        lines += ["    read_only: false"]
    if any(f"{there}/" in word for word in program.arguments for there in mounts.values()):
        volumes = [
            {"type": "bind", "source": here, "target": there, "read_only": True} for here, there in mounts.items()
        ]
        lines += ["    volumes:", *(f"      - {json.dumps(volume)}".replace("$", "$$") for volume in volumes)]
    if program.role != "router":
        lines += ["    depends_on: [router]"]
    if program.role == "recorder":
        lines += ["    volumes:", f'      - "records:{RECORDS}"']
    if program.role == "dashboard":
        lines += [
            "    ports:",
            f'      - "127.0.0.1:{PAGE_PORT}:{PAGE_PORT}"',
        ]
    return "\n".join(lines) + "\n"


def _words(command: Sequence[str]) -> str:
    """A command as YAML has it; compose would take a $ for a variable."""
    return json.dumps(command).replace("$", "$$")
