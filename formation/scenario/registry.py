"""The controllers by name: their options, colour, and what a run has to know of them. One line each.

Each is made by the module of its name (agents/controllers/registry.py). Controllers of a user's own are added by who
loads them (agents/controllers/own.py), and by name alone where they are not loaded: by the world and the page.
"""

from collections.abc import Iterable
from dataclasses import dataclass

from formation.errors import ScenarioError, unknown
from formation.scenario.controllers import (
    CentralisedOptions,
    ConsensusOptions,
    ControllerOptions,
    LeaderFollowerOptions,
    NashOptions,
    PaperOptions,
    VirtualStructureOptions,
)
from formation.scenario.user_code import UserCode, opaque_options


@dataclass(frozen=True, slots=True)
class ControllerSpec:
    """What is known of a controller without loading it."""

    options: type[ControllerOptions]
    colour: str
    """In every figure, rrggbb (Okabe and Ito 2008); of a user's own, empty for a free one."""
    ages_plans: bool = False
    """Whether it rolls a received plan forward to now unless the scenario sets `age_plans`."""
    in_process_only: bool = False
    """Whether it is one controller for all robots, which needs their true poses: no agent process can have it."""
    estimates: bool = True
    """Whether it gets estimates; else the newest measured pose as it is."""
    needs_path: bool = False
    """Whether every robot must know the path itself; else it also runs with path.known_to = "leader"."""
    rounds_corners: bool = True
    """Whether its references turn corners feasibly; else it follows the paper's, jumps included."""
    code: UserCode | None = None
    """Of a controller of a user's own."""

    @property
    def name(self) -> str:
        """As a scenario names it."""
        return str(self.options.model_fields["name"].default)


_SPECS = (
    ControllerSpec(NashOptions, "0072B2", ages_plans=True),
    ControllerSpec(PaperOptions, "D55E00", estimates=False, needs_path=True, rounds_corners=False),
    ControllerSpec(LeaderFollowerOptions, "CC79A7", estimates=False, needs_path=True, rounds_corners=False),
    ControllerSpec(VirtualStructureOptions, "009E73", needs_path=True),
    ControllerSpec(ConsensusOptions, "E69F00", ages_plans=True),
    ControllerSpec(CentralisedOptions, "222222", in_process_only=True, estimates=False, needs_path=True),
)
CONTROLLERS: dict[str, ControllerSpec] = {spec.name: spec for spec in _SPECS}
DEFAULT = _SPECS[0].name
"""Of a scenario that names no controller."""
BUILT_IN = tuple(CONTROLLERS)
IN_PROCESS = tuple(name for name, spec in CONTROLLERS.items() if spec.in_process_only)


def names() -> tuple[str, ...]:
    """Every controller that this process knows."""
    return tuple(CONTROLLERS)


def live() -> tuple[str, ...]:
    """What can run as processes."""
    return tuple(name for name in CONTROLLERS if name not in IN_PROCESS)


def told() -> tuple[str, ...]:
    """What can run where robot 1 alone knows the path."""
    return tuple(name for name, spec in CONTROLLERS.items() if not spec.needs_path)


def own_controllers() -> list[UserCode]:
    """The controllers of users' own that this process knows."""
    return [spec.code for spec in CONTROLLERS.values() if spec.code is not None]


def check_free(name: str) -> None:
    """Refuse a user's own controller with the name of a built-in one.

    Raises:
        ScenarioError: there is such a one.
    """
    if name in BUILT_IN:
        raise ScenarioError(
            f"--controller: expected a class with a name of its own; got {name}, which is built in "
            f"({', '.join(BUILT_IN)})"
        )


def register(spec: ControllerSpec) -> None:
    """Add a controller of a user's own, or replace one that was loaded earlier under its name. Raises ScenarioError."""
    check_free(spec.name)
    CONTROLLERS[spec.name] = spec


def register_unloaded(codes: Iterable[UserCode]) -> None:
    """Add controllers by what is known of them; those that are loaded here, in the same text, stay.

    Raises:
        ScenarioError: a built-in one has the name, or it is loaded here with another text.
    """
    for code in codes:
        if code.kind != "controller":
            continue
        held = CONTROLLERS.get(code.name)
        if held is None or held.code is None or held.code.sha256 != code.sha256:
            register(ControllerSpec(opaque_options(code), code.colour, ages_plans=code.ages_plans, code=code))


def spec_of(options: ControllerOptions) -> ControllerSpec:
    """The spec of a scenario's controller."""
    return CONTROLLERS[options.name]


def check_name(name: str, *others: str) -> str:
    """The name, if there is such a controller or it is one of the others.

    Raises:
        ScenarioError: it is neither; the text lists what there is.
    """
    if name not in (*names(), *others):
        raise ScenarioError(unknown_controller(name, *others))
    return name


def unknown_controller(name: str, *others: str) -> str:
    """Text for a controller that this process does not know."""
    text = unknown("controller.name", name, [*names(), *others])
    return text + "; code of your own is named on the command line: --controller FILE.py:CLASS"


def refusal(name: str) -> ScenarioError:
    """The error for a controller of `IN_PROCESS` that was to run as processes."""
    return ScenarioError(
        f"controller.name: {name} plans for all robots in one process: expected run --engine inprocess, "
        f"or a controller that runs as processes ({', '.join(live())})"
    )


def check_live(name: str) -> None:
    """Refuse a controller that cannot run as processes.

    Raises:
        ScenarioError: it is one of `IN_PROCESS`.
    """
    if name in IN_PROCESS:
        raise refusal(name)
