"""The controllers by name: which there are, how many weights each has, and which can fly as processes."""

from typing import Literal, get_args

from formation.errors import ScenarioError

ControllerName = Literal["nash", "paper", "leader_follower", "virtual_structure", "consensus", "centralised"]
NAMES: tuple[ControllerName, ...] = get_args(ControllerName)
IN_PROCESS: tuple[ControllerName, ...] = ("centralised",)
"""One mind for all robots, which sees their true poses: no agent that is a process of its own can have it."""
LIVE: tuple[ControllerName, ...] = tuple(name for name in NAMES if name not in IN_PROCESS)
"""What can fly over processes."""
WEIGHTS: dict[ControllerName, int] = {"nash": 6, "centralised": 6, "paper": 5, "virtual_structure": 3}
"""Length of the diagonal of Q; who is not named has no Q."""
AGEING: tuple[ControllerName, ...] = ("nash", "consensus")
"""Who rolls a received plan forward to now unless the scenario says otherwise."""


def refusal(name: ControllerName) -> ScenarioError:
    """Why a controller of `IN_PROCESS` cannot fly as processes."""
    return ScenarioError(
        f"controller.name: {name} is one mind for all robots: expected run --engine inprocess, "
        f"or a controller that flies over processes ({', '.join(LIVE)})"
    )


def check_live(name: ControllerName) -> None:
    """Refuse a controller that cannot fly as processes.

    Raises:
        ScenarioError: it is one of `IN_PROCESS`.
    """
    if name in IN_PROCESS:
        raise refusal(name)
