"""The controllers by name: which there are, how many weights each has, and which can run as processes."""

from typing import Literal, get_args

from formation.errors import ScenarioError

ControllerName = Literal["nash", "paper", "leader_follower", "virtual_structure", "consensus", "centralised"]
NAMES: tuple[ControllerName, ...] = get_args(ControllerName)
IN_PROCESS: tuple[ControllerName, ...] = ("centralised",)
"""Controllers that plan for all robots in one process, with their true poses; no separate agent can run them."""
LIVE: tuple[ControllerName, ...] = tuple(name for name in NAMES if name not in IN_PROCESS)
"""Controllers that can run as processes."""
WEIGHTS: dict[ControllerName, int] = {"nash": 6, "centralised": 6, "paper": 5, "virtual_structure": 3}
"""Length of the diagonal of Q; a controller that is not named has no Q."""
AGEING: tuple[ControllerName, ...] = ("nash", "consensus")
"""Controllers that carry a received plan forward to now by default."""


def refusal(name: ControllerName) -> ScenarioError:
    """The error for a controller of `IN_PROCESS` that was to run as processes."""
    return ScenarioError(
        f"controller.name: {name} plans for all robots in one process: expected run --engine inprocess, "
        f"or a controller that runs as processes ({', '.join(LIVE)})"
    )


def check_live(name: ControllerName) -> None:
    """Refuse a controller that cannot run as processes.

    Raises:
        ScenarioError: it is one of `IN_PROCESS`.
    """
    if name in IN_PROCESS:
        raise refusal(name)
