"""The messages between the processes of a run. Each is a frozen value with sender, seq and stamp.

`stamp` is simulated time [s]; `episode` changes with every reset, so that messages of an earlier episode are not taken
for messages of this one. Robots are numbered from 1. network/codec.py encodes and decodes them.
"""

from dataclasses import dataclass, field
from typing import Any, Literal

from formation import links
from formation.faults import Fault
from network.fields import (
    STRICT,
    Count,
    Flag,
    Inputs,
    Link,
    LongText,
    NonNegative,
    Numbers,
    Pose,
    Poses,
    Positive,
    Real,
    Sender,
    Text,
)

VERSION = 2
"""Of the wire: processes of another version refuse each other's bytes."""
WORLD = links.WORLD
"""Sender number of the world; robots count from 1."""

Severity = Literal["info", "warning", "error"]
Mode = Literal["lockstep", "realtime"]
"""Whether the world waits for every agent at every tick, or steps by the wall clock."""


@dataclass(frozen=True, slots=True, eq=False)
class Tick:
    """World to all: simulated time has reached `stamp`; the measured poses at this time."""

    sender: Sender
    seq: Count
    """k, the number of the tick."""
    stamp: NonNegative
    episode: Count
    revision: Count
    """Number of the `Setup` that is valid from this tick on."""
    poses: Poses
    """Measured poses of all robots. An agent reads its own row only."""
    planned: list[Sender]
    """Robots that sent a plan at tick k - 1. In lockstep the one downstream waits for it."""
    last: Flag = False
    """Whether this is the last tick of the episode."""
    gone: list[Sender] = field(default_factory=list)
    """Robots that the world lost while this tick was out: nobody waits for a plan of theirs any more."""
    __pydantic_config__ = STRICT


@dataclass(frozen=True, slots=True, eq=False)
class Plan:
    """Agent to its downstream neighbour: its pose and its inputs over the horizon."""

    sender: Sender
    seq: Count
    """k of the tick it answers."""
    stamp: NonNegative
    episode: Count
    pose: Pose
    """Pose of the sender at `stamp`, as measured or carried forward by it [m, m, rad]."""
    interval: Positive
    """Delta_T: how long each input is held [s]."""
    inputs: Inputs
    lag: NonNegative = 0.0
    """How far its reference time is behind the clock, because it waits [s]; docs/theory.md, section 6."""
    lag_rate: Real = 0.0
    """Rate of change of its lag that is its own doing: 1 while it cannot keep up, below 0 while it catches up."""
    __pydantic_config__ = STRICT


@dataclass(frozen=True, slots=True)
class Command:
    """Agent to world: the input for tick k, and the data that it was computed from."""

    sender: Sender
    seq: Count
    """k of the tick it answers."""
    stamp: NonNegative
    episode: Count
    v: Real
    """[m/s]."""
    omega: Real
    """[rad/s]."""
    age: NonNegative
    """Age of the upstream neighbour's plan that was used [s]."""
    planned: Flag
    """Whether a plan was sent at this tick."""
    solve: NonNegative
    """Wall-clock time of planning [s]; 0 at a tick without planning."""
    converged: Flag = True
    """Whether the solver converged for the plan that v and omega are from; if not, they are a fallback."""
    __pydantic_config__ = STRICT


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


@dataclass(frozen=True, slots=True, eq=False)
class Status:
    """Agent to displays, ten times a second: its plans, its link, its solver."""

    sender: Sender
    seq: Count
    stamp: NonNegative
    episode: Count
    link: Link
    """Name of the link from its upstream neighbour."""
    age: NonNegative
    """Age of the newest plan that arrived over it [s]."""
    plan: Plan | None
    """The newest plan that it sent; None before the first."""
    held: Plan | None
    """The newest plan of its upstream neighbour that arrived, however old; None before the first."""
    counts: LinkCounts
    solve: NonNegative
    """Mean wall-clock time per plan since the last status [s]."""
    missed: Count
    """Ticks that it did not answer in time (real time only)."""
    gap: NonNegative
    """Nash gap: how much the robot could lower its cost by changing its own plan alone (docs/theory.md, section 5)."""
    rejected: Count
    """Payloads that were not valid messages."""
    pid: Count
    converged: Flag = True
    """As in the Command of the same tick."""
    __pydantic_config__ = STRICT


@dataclass(frozen=True, slots=True)
class Event:
    """An entry of the run's event log."""

    number: Count
    stamp: NonNegative
    kind: Literal["run", "fault", "agent", "watchdog", "wire"]
    text: Text
    severity: Severity = "info"
    """How much it matters; info also when something is well again. Set by who raises the event."""
    __pydantic_config__ = STRICT


RunStatus = Literal["waiting", "running", "paused", "finished"]


@dataclass(frozen=True, slots=True, eq=False)
class State:
    """World to displays, twenty times a second: poses, errors, faults and events."""

    sender: Sender
    seq: Count
    stamp: NonNegative
    episode: Count
    revision: Count
    scenario: Text
    controller: Text
    mode: Mode
    status: RunStatus
    waiting_for: list[Sender]
    """Robots without a live agent."""
    dismissed: list[Sender]
    """Robots whose agents users have killed: the launcher keeps these down."""
    speed: NonNegative
    """Requested simulated seconds per second; 0 means as fast as possible."""
    pace: NonNegative
    """Simulated seconds per second over the last second."""
    overruns: Count
    """Ticks that began late (real time only)."""
    rejected: Count
    """Payloads to the world that were not valid messages."""
    poses: Poses
    """True poses."""
    slots: Poses
    """Slots: the reference poses of the robots."""
    centre: Pose
    """Reference position of the formation's centre, with the path's heading."""
    distance_errors: Numbers
    """(n,) l_e [m]."""
    angle_errors: Numbers
    """(n,) psi_e [rad]."""
    tracking_error: NonNegative
    """[m]."""
    live: list[Sender]
    """Robots with a live agent."""
    stopped: list[Sender]
    """Robots that the watchdog has stopped."""
    faults: dict[Link, Fault]
    """Every link that is not perfect, with the keys of formation.faults.Fault that differ from its default."""
    events: list[Event]
    """The newest events, oldest first."""
    compare: Text
    """Controller of the requested ghost; empty for none."""
    __pydantic_config__ = STRICT


@dataclass(frozen=True, slots=True, eq=False)
class Ghost:
    """Ghost to displays, after a State: the same episode at that stamp under another controller, the same faults."""

    sender: Sender
    seq: Count
    stamp: NonNegative
    episode: Count
    controller: Text
    poses: Poses
    distance_errors: Numbers
    """(n,) l_e [m]."""
    angle_errors: Numbers
    """(n,) psi_e [rad]."""
    tracking_error: NonNegative
    """[m]."""
    __pydantic_config__ = STRICT


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
    faults: dict[Link, Fault]
    """As in State."""
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


Message = Tick | Plan | Command | Status | State | Ghost | Setup | Request | Reply
