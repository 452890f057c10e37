"""The controllers by name: their options, colour, and what a run has to know of them. One line each.

Each is made by the module of its name (agents/controllers/registry.py).
"""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Union

from pydantic import BeforeValidator, Field

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


@dataclass(frozen=True, slots=True)
class ControllerSpec:
    """What is known of a controller without loading it."""

    options: type[ControllerOptions]
    colour: str
    """In every figure, rrggbb (Okabe and Ito 2008)."""
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
NAMES = tuple(CONTROLLERS)
IN_PROCESS = tuple(name for name, spec in CONTROLLERS.items() if spec.in_process_only)
LIVE = tuple(name for name in NAMES if name not in IN_PROCESS)
"""What can run as processes."""


TOLD = tuple(name for name, spec in CONTROLLERS.items() if not spec.needs_path)
"""What can run where robot 1 alone knows the path."""


def _named(given: object) -> object:
    """The table of a controller with the name that it has by default."""
    return {"name": DEFAULT, **given} if isinstance(given, dict) else given


if TYPE_CHECKING:
    AnyController = ControllerOptions
else:
    AnyController = Annotated[
        Union[tuple(spec.options for spec in CONTROLLERS.values())],  # noqa: UP007  made of the table
        Field(discriminator="name"),
        BeforeValidator(_named),
    ]


def spec_of(options: ControllerOptions) -> ControllerSpec:
    """The spec of a scenario's controller."""
    return CONTROLLERS[options.name]


def check_name(name: str, *others: str) -> str:
    """The name, if there is such a controller or it is one of the others.

    Raises:
        ValueError: it is neither; the text lists what there is.
    """
    if name not in (*NAMES, *others):
        raise ValueError(unknown("controller", name, [*NAMES, *others]).partition(": ")[2])
    return name


def refusal(name: str) -> ScenarioError:
    """The error for a controller of `IN_PROCESS` that was to run as processes."""
    return ScenarioError(
        f"controller.name: {name} plans for all robots in one process: expected run --engine inprocess, "
        f"or a controller that runs as processes ({', '.join(LIVE)})"
    )


def check_live(name: str) -> None:
    """Refuse a controller that cannot run as processes.

    Raises:
        ScenarioError: it is one of `IN_PROCESS`.
    """
    if name in IN_PROCESS:
        raise refusal(name)
