"""The same processes as containers: a compose file made of runtime/process_list.py."""

import json
from collections.abc import Container, Mapping, Sequence

from formation.errors import ScenarioError
from formation.loading.source import LOADED
from formation.scenario.overrides import Overrides, to_json
from formation.scenario.registry import check_live
from formation.scenario.scenario import Scenario
from network.access.rules import MAX_KEYED
from runtime.process_list import Program, RunPlan, programs
from runtime.user_code import NO_CODE, CodeArguments, mounted

RUN = "echelon"
ROUTER_PORT = 7447
PAGE_PORT = 8090
SAVED = "/var/lib/echelon"
"""Where the world saves the run, in its own container; the image has the folder with the right owner."""
RECORDS = "/records"
"""Where records are, in a volume of the same name; the image has the folder with the right owner."""
KEYS = "/keys"
"""Where the keys of the run are, in a volume that its containers alone see; the image has the folder, private."""
ISSUING = ("python", "-m", "runtime.hosts.issuing", "--folder", KEYS)
"""Makes them, before anything else starts."""

_CHOSEN = "${{SCENARIO:-{}}}"
"""The scenario's name as compose makes it of the environment."""

_HEAD = """\
# Made by `echelon compose {words}`: router, world, the agents of all robots, ghost, dashboard.
# `docker compose up --build`, then open http://127.0.0.1:{port}. Only that port is published, on loopback.
# `SCENARIO=NAME docker compose up` runs another scenario; `--scale agents=3` shares the agents among containers.
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
  volumes: ["keys:{keys}:ro"]
  environment:
    ECHELON_CONNECT: "tls/router:{router}"  # `docker compose exec world echelon status` needs no options
    ECHELON_RUN: "{run}"
    ECHELON_KEYS: "{keys}"
    ECHELON_IN_CONTAINER: "1"

networks:
  formation: {{}}

volumes:
  keys: {{}}  # of this run alone: `docker compose down -v` removes them
{volumes}
services:
  keys:  # made once, before all else
    <<: *service
    command: {issuing}
    volumes: ["keys:{keys}"]

"""


def plan(
    scenario: str, overrides: Overrides, code: CodeArguments = NO_CODE, *, record: bool = False, realtime: bool = False
) -> RunPlan:
    """How a run of containers is put together. The scenario is that of the environment, if there is one."""
    scenario = _CHOSEN.format(scenario)
    return RunPlan(
        run=RUN,
        scenario=scenario,
        connect=f"tls/router:{ROUTER_PORT}",
        listen=(f"tls/0.0.0.0:{ROUTER_PORT}",),
        keys=KEYS,
        overrides=overrides,
        realtime=realtime,
        endless=True,
        ghost=True,
        folder=SAVED,
        containers=True,
        code=code,
        dashboard=("0.0.0.0", PAGE_PORT),  # of its container; published on loopback only
        record=f"{RECORDS}/{scenario}.mcap" if record else None,
    )


def compose_file(
    name: str,
    scenario: Scenario,
    overrides: Overrides | None = None,
    *,
    record: bool = False,
    realtime: bool = False,
) -> str:
    """The text of a compose file that runs the scenario.

    Args:
        name: of a shipped scenario: the image holds no others.
        scenario: the same, loaded.
        overrides: what differs from it.
        record: whether the run is recorded, in a volume.
        realtime: whether the world goes by the wall clock, and waits for nobody.

    Raises:
        ScenarioError: its controller cannot run as processes, or there are too many robots.
    """
    check_live(scenario.controller.name)
    if scenario.size > MAX_KEYED:
        raise ScenarioError(f"expected at most {MAX_KEYED} robots, as there are keys for; got {scenario.size}")
    words = " ".join([name, *([f"with {to_json(overrides)}"] if overrides else [])])
    head = _HEAD.format(
        words=words,
        port=PAGE_PORT,
        router=ROUTER_PORT,
        run=RUN,
        keys=KEYS,
        issuing=_words(ISSUING),
        volumes="  records: {}\n" if record else "",
    )
    code, mounts = mounted(LOADED.values())
    planned = plan(name, overrides or {}, code, record=record, realtime=realtime)
    chosen = {planned.scenario, planned.record or ""}
    services = "\n".join(_service(program, mounts, chosen) for program in programs(planned, scenario))
    return head + services


def service_name(program: Program) -> str:
    """What a process is called as a service: `--scale agents=3`."""
    return "agents" if program.role == "keeper" else program.role


def _service(program: Program, mounts: Mapping[str, str], chosen: Container[str]) -> str:
    name = service_name(program)
    check = ["CMD", "python", "-m", "network.health", "--run", RUN, "--connect", f"tls/router:{ROUTER_PORT}"]
    check += ["--keys", KEYS, "--role", program.role]
    lines = [
        f"  {name}:",
        "    <<: *service",
        *(["    build: ."] if program.role == "router" else []),
        f"    command: {_words(['python', '-m', program.module, *program.arguments], chosen)}",
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
        more = [json.dumps(volume).replace("$", "$$") for volume in volumes]
    else:
        more = [f'"records:{RECORDS}"'] if program.role == "recorder" else []
    if more:
        lines += ["    volumes:", *(f"      - {volume}" for volume in [f'"keys:{KEYS}:ro"', *more])]
    if program.role == "router":
        lines += ["    depends_on: {keys: {condition: service_completed_successfully}}"]
    else:
        lines += ["    depends_on: [router]"]
    if program.role == "dashboard":
        lines += [
            "    ports:",
            f'      - "127.0.0.1:{PAGE_PORT}:{PAGE_PORT}"',
        ]
    return "\n".join(lines) + "\n"


def _words(command: Sequence[str], chosen: Container[str] = ()) -> str:
    """A command as YAML has it; compose would take a $ for a variable, and shall in the words that are chosen there."""
    return json.dumps([word if word in chosen else word.replace("$", "$$") for word in command])
