"""What messages are made of: small values, the empty arrays of each shape, and quick constructors."""

from collections.abc import Callable
from dataclasses import MISSING, dataclass, fields
from typing import Any, Literal, ParamSpec, TypeVar

import numpy as np

from formation.arrays import FloatArray, frozen
from network.fields import STRICT, Count, Far, Fast, Inputs, NonNegative, Pose, Positive, Sender, Text

P = ParamSpec("P")
T = TypeVar("T")
Severity = Literal["info", "warning", "error"]
Mode = Literal["lockstep", "realtime"]
"""Whether the world waits for every agent at every tick, or steps by the wall clock."""


STILL: FloatArray = frozen(np.zeros(2))
NO_POSES, NO_PLACES, NO_SUMS, NOBODY_SEEN = (frozen(np.zeros((0, columns))) for columns in (3, 2, 4, 3))
NO_MEASUREMENTS, NO_NEWS, NO_WAY, NO_DRIVE = (frozen(np.zeros((0, columns))) for columns in (9, 4, 6, 11))
"""Nothing, of each shape."""


@dataclass(frozen=True, slots=True)
class LinkCounts:
    """Message counts of one link so far."""

    sent: Count = 0
    delivered: Count = 0
    """Arrived, copies included."""
    lost: Count = 0
    late: Count = 0
    """Dropped because a newer one had arrived before (part of delivered)."""
    corrupt: Count = 0
    """Refused because of flipped bytes (part of delivered)."""
    duplicated: Count = 0
    """Copies the link made (sent + duplicated = delivered + lost + in_flight)."""
    in_flight: Count = 0
    __pydantic_config__ = STRICT


@dataclass(frozen=True, slots=True)
class Event:
    """An entry of the run's event log."""

    number: Count
    stamp: NonNegative
    kind: Literal["run", "fault", "agent", "watchdog", "contact", "avoidance", "wire", "drive", "push", "excursion"]
    text: Text
    severity: Severity = "info"
    """How much it matters; info also when something is well again. Set by who raises the event."""
    __pydantic_config__ = STRICT


@dataclass(frozen=True, slots=True)
class Driving:
    """What drives a formation whose path is driven."""

    orders: Count = 0
    """Number of orders in this episode."""
    v: Fast = 0.0
    """Speed that is ordered now [m/s]."""
    omega: Fast = 0.0
    """Turn rate that is ordered now [rad/s]."""
    goal: tuple[Far, Far] | None = None
    """Where the centre is driving to [m]; None if it follows an order."""
    __pydantic_config__ = STRICT


@dataclass(frozen=True, slots=True)
class Intervention:
    """What a user did to the robots of an episode, from a tick on: who simulates it again repeats it there."""

    tick: Count
    kind: Literal["push", "release", "shape", "ring"]
    value: dict[str, Any]
    """push: keys of a formation.disturbances.Disturbance. release: robot, None for all. shape: keys of a Change.
    ring: away, the robots over which it is closed, whoever caused that."""
    __pydantic_config__ = STRICT


@dataclass(frozen=True, slots=True)
class Pushed:
    """A disturbance that acts on a robot now."""

    robot: Sender
    text: Text
    """What it does."""
    until: NonNegative | None = None
    """When it ends [s]."""
    __pydantic_config__ = STRICT


@dataclass(frozen=True, slots=True, eq=False)
class Motion:
    """Where a robot is to drive: a pose, and the inputs from there on."""

    begins: NonNegative
    """Time of the pose [s]."""
    pose: Pose
    interval: Positive
    """How long each input is held [s]."""
    inputs: Inputs
    """(N, 2) mean body velocities over the intervals."""
    __pydantic_config__ = STRICT


@dataclass(frozen=True, slots=True)
class Excursion:
    """A robot's error above its limit, once."""

    number: Count
    """In the episode, from 1."""
    robot: Sender
    at: NonNegative
    """When the error rose above the limit [s]."""
    peak: NonNegative
    """Largest error [m]."""
    peak_at: NonNegative
    """[s]."""
    until: NonNegative | None = None
    """When it fell below the limit again [s]; None while it goes on."""
    recovery: NonNegative | None = None
    """From the end of its cause, or from its peak if that goes on, until then [s]."""
    cause: Text = ""
    """The likely one."""
    cause_at: NonNegative | None = None
    """When that began [s]."""
    __pydantic_config__ = STRICT


RecordWish = Literal["", "on", "off"]
"""Whether users want the run to be recorded; empty: as it was started."""
RunStatus = Literal["waiting", "running", "paused", "finished"]


def maker(kind: Callable[P, T]) -> Callable[P, T]:
    """Makes what the frozen dataclass with slots `kind` makes of the same arguments, in a third of the time.

    The generated constructor costs 0.4 us a field: keywords pass through a dictionary on their way to `__init__`, which
    calls `object.__setattr__` for each. The function made here gets them at once, and fills an instance of an open
    class of the same layout, which then becomes one of the frozen class.
    """
    own = fields(kind)  # type: ignore[arg-type]
    opened = type("Open", (), {"__slots__": tuple(f.name for f in own)})
    names: dict[str, Any] = {"opened": opened, "kind": kind, "new": object.__new__, "MISSING": MISSING}
    head, body = [], []
    for f in own:
        value, default = f.name, ""
        if f.default is not MISSING:
            names[f"default_{f.name}"], default = f.default, f"=default_{f.name}"
        elif f.default_factory is not MISSING:
            names[f"make_{f.name}"], default = f.default_factory, "=MISSING"
            value = f"make_{f.name}() if {f.name} is MISSING else {f.name}"
        head.append(f.name + default)
        body.append(f" made.{f.name} = {value}")
    lines = [f"def make({', '.join(head)}):", " made = new(opened)", *body, " made.__class__ = kind", " return made"]
    exec("\n".join(lines), names)
    make: Callable[P, T] = names["make"]
    return make


def tuple_maker(kind: Callable[P, T]) -> Callable[P, T]:
    """Makes what the NamedTuple `kind` makes of the same arguments, in two thirds of the time: no class is called."""
    names: tuple[str, ...] = kind._fields  # type: ignore[attr-defined]
    defaults: dict[str, Any] = kind._field_defaults  # type: ignore[attr-defined]
    known = {"new": tuple.__new__, "kind": kind, **{f"default_{name}": value for name, value in defaults.items()}}
    head = ", ".join(f"{name}=default_{name}" if name in defaults else name for name in names)
    exec(f"def make({head}): return new(kind, ({', '.join(names)},))", known)
    make: Callable[P, T] = known["make"]
    return make
