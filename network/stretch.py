"""What recorders get of the world: some ticks of an episode as they were, and what was ordered meanwhile."""

from dataclasses import dataclass, field
from typing import Any, Literal

from formation.scenario.user_code import UserCode
from network.fields import STRICT, Count, Inputs, LongText, NonNegative, Pose, Poses, Sender, Text
from network.values import Event, Excursion, Mode

Kind = Literal["faults", "drive", "agents", "push", "release", "shape", "ring"]


@dataclass(frozen=True, slots=True)
class Order:
    """What changed the episode from a tick on: who simulates it again repeats it there."""

    number: Count
    """In the episode, from 0 without gaps."""
    tick: Count
    kind: Kind
    """A table of faults, an order of the driver, which robots answer from this tick on, or an Intervention."""
    value: dict[str, Any]
    """faults: by link, the keys that differ from a perfect one. drive: v [m/s], omega [rad/s]. agents: answered, a list
    of robots. The others as in an Intervention."""
    __pydantic_config__ = STRICT


@dataclass(frozen=True, slots=True, eq=False)
class Stretch:
    """World to recorders, while there is one: every pose since the stretch before, and what happened."""

    sender: Sender
    seq: Count
    """In the episode, since the recorder appeared."""
    stamp: NonNegative
    """Of the last poses."""
    episode: Count
    first: Count
    """Tick of the first poses."""
    poses: Poses
    """(T n, 3) true poses of n robots at T ticks, tick by tick."""
    inputs: Inputs
    """(T n, 2) commanded inputs over the tick that led there."""
    slots: Poses
    """(n, 3) slots at the last tick."""
    centre: Pose
    """Reference position of the formation's centre at the last tick, with the path's heading."""
    mode: Mode
    orders: list[Order] = field(default_factory=list)
    events: list[Event] = field(default_factory=list)
    excursions: list[Excursion] = field(default_factory=list)
    """That are over, or go on when the episode ends."""
    scenario: LongText = ""
    """JSON of the scenario, in the first stretch of an episode and in the first that a recorder gets; else empty."""
    resumed: list[Count] = field(default_factory=list)
    """With the scenario: ticks from which on a world went on from a saved state, and every agent began anew."""
    user_code: list[UserCode] = field(default_factory=list)
    """With the scenario: the code of a user's own that it runs with."""
    __pydantic_config__ = STRICT


@dataclass(frozen=True, slots=True)
class Recording:
    """Recorder to world, with every chunk that it has closed: how its record stands."""

    sender: Sender
    seq: Count
    stamp: NonNegative
    """Of the newest poses in it."""
    episode: Count
    file: Text
    bytes: Count
    """On disk."""
    seconds: NonNegative
    """Since it began [s of wall clock]."""
    __pydantic_config__ = STRICT
