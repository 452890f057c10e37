"""The processes of a run, all in one list: what `echelon up` starts and what compose.yaml holds."""

from collections.abc import Iterable
from dataclasses import dataclass, field

from formation.scenario.overrides import Overrides, to_json
from formation.scenario.scenario import Scenario
from network.access.robot_numbers import spelled
from runtime.user_code import NO_CODE, CodeArguments


@dataclass(frozen=True, slots=True)
class Program:
    """One process: a module of ours with a main(arguments)."""

    role: str
    number: int
    """Of an agent or a body its robot's, else 0."""
    module: str
    arguments: tuple[str, ...]
    robots: frozenset[int] = frozenset()
    """Whose agents it has."""

    @property
    def name(self) -> str:
        """Name for the user: "world", "agent 2", "agents 1-32"."""
        if self.robots:
            return f"agent{'s' if len(self.robots) > 1 else ''} {spelled(self.robots)}"
        return f"{self.role} {self.number}" if self.number else self.role


@dataclass(frozen=True, slots=True)
class RunPlan:
    """How a run is put together."""

    run: str
    """Name of the run."""
    scenario: str
    """Name or file."""
    connect: str
    """The router's endpoint that its clients connect to."""
    listen: tuple[str, ...]
    """The router's endpoints that it listens on."""
    overrides: Overrides = field(default_factory=dict)
    """What differs from it."""
    keys: str | None = None
    """Folder with the keys of whatever is not on a unix socket."""
    insecure: bool = False
    """Whether endpoints that strangers can use are allowed."""
    together: int = 1
    """Agents in a process."""
    here: frozenset[int] | None = None
    """Robots whose agents are of this host; None: all."""
    realtime: bool = False
    speed: float = 1.0
    endless: bool = False
    paused: bool = False
    folder: str | None = None
    """The run's private folder: the world saves the run there, and the router removes it if no launcher is left."""
    containers: bool = False
    """Whether each process has a folder of its own there, which goes with its container, and agents are kept by one."""
    dashboard: tuple[str, int] | None = None
    """Host and port to serve the page on; None for a run without one."""
    started: str | None = None
    """File of the scenario that the run was started with, for the page."""
    scenarios: str | None = None
    """Folder whose scenarios the page offers besides the shipped ones."""
    ghost: bool = False
    """Whether the run has a ghost process, for comparisons with another controller."""
    record: str | None = None
    """File that the run is recorded in; None for a run without a recorder."""
    detail: str = "default"
    """Of the record."""
    token: str | None = None
    """Token that browsers must send; None on loopback."""
    code: CodeArguments = NO_CODE
    """Code of users' own."""
    robots: tuple[tuple[int, str], ...] = ()
    """Real robots: number, and what their body's process is told of them."""
    ros: tuple[str, int] | None = None
    """Endpoint and domain of the ROS 2 that sees the formation; None for none."""


def programs(plan: RunPlan, scenario: Scenario) -> list[Program]:
    """Every process of the run, in the order in which they are best started."""
    common = _common(plan)
    world = [*common, "--scenario", plan.scenario, "--speed", f"{plan.speed:g}"]
    if plan.overrides:
        world += ["--overrides", to_json(plan.overrides)]
    world += ["--controllers", plan.code.known] if plan.code.known else []
    world += _each("--bodies", plan.code.bodies)
    world += ["--folder", plan.folder] if plan.folder else []
    world += [flag for flag, on in _flags(plan) if on]
    world += _each("--real", tuple(str(number) for number, _ in plan.robots))
    router = (*_each("--listen", plan.listen), "--run", plan.run, *_doors(plan))
    router += ("--folder", plan.folder) if plan.folder and not plan.containers else ()
    found = [Program("router", 0, "network", router), Program("world", 0, "world", tuple(world))]
    if plan.record is not None:  # before the agents: what happens at once is to be in the record
        found.append(recorder(plan, plan.record))
    found += [Program("body", number, "ros.body", (*common, "--robot", spec)) for number, spec in plan.robots]
    robots = [number for number in range(1, scenario.size + 1) if plan.here is None or number in plan.here]
    found += [keeper(plan)] if plan.containers else agents(plan, robots)
    if plan.ghost:
        own = [*_each("--controller", plan.code.controllers), *_each("--bodies", plan.code.bodies)]
        found.append(Program("ghost", 0, "runtime.ghost", (*common, *own)))
    if plan.ros is not None:
        endpoint, domain = plan.ros
        real = _each("--real", tuple(str(number) for number, _ in plan.robots))
        found.append(Program("display", 0, "ros.display", (*common, "--ros", endpoint, "--domain", str(domain), *real)))
    if plan.dashboard is not None:
        host, port = plan.dashboard
        where = ("--host", host, "--port", str(port), *((f"--token={plan.token}",) if plan.token else ()))
        offered = (("--started", plan.started), ("--scenarios", plan.scenarios))
        more = [word for flag, value in offered if value for word in (flag, value)]
        found.append(Program("dashboard", 0, "dashboard", (*common, *where, *more)))
    return found


def recorder(plan: RunPlan, file: str) -> Program:
    """Records the run in a file."""
    return Program("recorder", 0, "records", (*_common(plan), "--file", file, "--detail", plan.detail))


def agents(plan: RunPlan, robots: Iterable[int]) -> list[Program]:
    """The agents of these robots: a process each, or `plan.together` of them in a process."""
    own, ordered, size = _each("--controller", plan.code.controllers), sorted(robots), plan.together
    found = []
    for some in (ordered[at : at + size] for at in range(0, len(ordered), size)):
        who = ("--id", str(some[0])) if len(some) == 1 else ("--together", "--ids", spelled(some))
        number = some[0] if len(some) == 1 else 0
        found.append(Program("agent", number, "agents", (*_common(plan), *own, *who), frozenset(some)))
    return found


def keeper(plan: RunPlan) -> Program:
    """Runs the agents of all robots that the scenario has, or its share of them beside others of its kind."""
    return Program("keeper", 0, "runtime.keeping", (*_common(plan), *_each("--controller", plan.code.controllers)))


def _common(plan: RunPlan) -> tuple[str, ...]:
    """What every client of the router needs."""
    local = plan.connect.startswith("unixsock-stream/")
    return ("--run", plan.run, "--connect", plan.connect, *(() if local else _doors(plan)))


def _doors(plan: RunPlan) -> tuple[str, ...]:
    keys = ("--keys", plan.keys) if plan.keys else ()
    return (*keys, *(("--insecure",) if plan.insecure else ()))


def _each(option: str, values: tuple[str, ...]) -> list[str]:
    return [word for value in values for word in (option, value)]


def _flags(plan: RunPlan) -> list[tuple[str, bool]]:
    return [("--realtime", plan.realtime), ("--endless", plan.endless), ("--paused", plan.paused)]
