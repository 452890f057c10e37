"""What is asked of the world, and what it answers: queries, where network/messages.py has what is published."""

from dataclasses import dataclass, field
from typing import Any

from formation.faults import Fault
from formation.scenario.user_code import UserCode
from network.fields import STRICT, Count, Flag, Link, LongText, NonNegative, Sender, Text
from network.values import Mode


@dataclass(frozen=True, slots=True)
class Setup:
    """World to whoever asks: scenario, mode and faults. An agent that receives a new revision in a tick asks for it."""

    sender: Sender
    seq: Count
    stamp: NonNegative
    episode: Count
    revision: Count
    scenario: LongText
    """JSON of the formation.scenario.Scenario, with the controller in use."""
    mode: Mode
    faults: dict[Link, Fault]  # as in State
    changes: list[dict[str, Any]] = field(default_factory=list)
    """Changes of the shape that users made in this episode: keys of a formation.formation_spec.Change."""
    away: list[Sender] = field(default_factory=list)
    """Robots over which the ring is closed."""
    closed_at: Count = 0
    """Tick from which on that is so: whoever has another neighbour since then begins anew there."""
    user_code: list[UserCode] = field(default_factory=list)  # who has another text of it has no part in the run
    __pydantic_config__ = STRICT


@dataclass(frozen=True, slots=True)
class Request:
    """Client to world: an operation with its arguments; see network/control.py."""

    operation: Text
    arguments: dict[str, Any] = field(default_factory=dict)
    __pydantic_config__ = STRICT


@dataclass(frozen=True, slots=True)
class Reply:
    """World to client: done, or the reason why not."""

    ok: Flag
    reason: Text = ""
    """One line, if not ok."""
    value: dict[str, Any] = field(default_factory=dict)
    __pydantic_config__ = STRICT
