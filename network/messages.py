"""The messages between the processes of a run: frozen values with sender, seq and stamp, which is simulated time [s].

`stamp` is simulated time [s]; every reset begins another `episode`. Robots count from 1. Bytes: network/codec.py.
`episode` changes with every reset. Robots are numbered from 1. network/codec.py encodes and decodes the messages.
"""

from dataclasses import dataclass, field

from formation import link_ids
from formation.faults import Fault
from network import values
from network.bodies import BodyInput, BodyPose
from network.fields import (
    STRICT,
    Count,
    Drive,
    Flag,
    Inputs,
    Link,
    MaybePoses,
    Measurements,
    News,
    NonNegative,
    Numbers,
    Places,
    Pose,
    Poses,
    Positive,
    Real,
    Seen,
    Sender,
    Sums,
    Text,
    Velocity,
    Way,
)
from network.requests import Reply, Request, Setup
from network.stretch import Recording, Stretch
from network.values import Driving, Event, Excursion, LinkCounts, Mode, Pushed, RecordWish, RunStatus

VERSION = 8
"""Of the wire: processes of another version refuse each other's bytes."""
WORLD = link_ids.WORLD  # the sender number of the world


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
    odometry: Inputs
    """(n, 2) wheel speeds of all robots over the tick before. Of this and the rest an agent reads its own row only."""
    planned: list[Sender]
    """Robots that sent a plan at tick k - 1. In lockstep the one downstream waits for it."""
    measured: Count | None
    """The tick that the sensors measured; None if none delivers now."""
    poses: MaybePoses
    """(n, 3) localised poses; no rows if `measured` is None."""
    localised: list[Sender]
    """Robots whose localisation delivers."""
    relatives: Places
    """(n, 2) position of the upstream neighbour in the own frame; no rows without relative sensing."""
    last: Flag = False
    """Whether this is the last tick of the episode."""
    gone: list[Sender] = field(default_factory=list)
    """Robots that the world lost while this tick was out: nobody waits for a plan of theirs any more."""
    seen: Seen = field(default_factory=lambda: values.NOBODY_SEEN)
    """Bodies, with or without an agent, that robots see in their own frames; none where nobody looks."""
    drive: Drive = field(default_factory=lambda: values.NO_DRIVE)
    """To robot 1, over the link driver->1: what its driver sends at this tick."""
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
    """Pose of the sender when the plan begins, as it estimates it [m, m, rad]."""
    interval: Positive
    """Delta_T: how long each input is held [s]."""
    inputs: Inputs
    """(N, 2) mean body velocities over the intervals."""
    lag: NonNegative = 0.0
    """How far its reference time is behind the clock, because it waits [s]; docs/theory.md, sections 6 and 15."""
    lag_rate: Real = 0.0
    """Rate of change of its lag that is its own doing: 1 while it cannot keep up, below 0 while it catches up."""
    delay: NonNegative = 0.0
    """From `stamp` to when the plan begins: the time after which the sender's commands have an effect [s]."""
    waits: Flag = False
    """Whether it holds its lag up by its own need."""
    drift: Velocity = field(default_factory=lambda: values.STILL)
    """Estimated velocity that carries it sideways, in the world frame [m/s]."""
    twist: Velocity = field(default_factory=lambda: values.STILL)
    """Mean body velocity from `stamp` to `begins` [m/s, rad/s]."""
    disturbance: Velocity = field(default_factory=lambda: values.STILL)
    """What it estimates to disturb its v and omega [m/s, rad/s]."""
    odometry: Sums = field(default_factory=lambda: values.NO_SUMS)
    """Since its agent began: of the sender, then of the robots upstream of it that it passes on."""
    measurements: Measurements = field(default_factory=lambda: values.NO_MEASUREMENTS)
    """Raw measurements of the same robots, each with its own tick; hop 0 is the sender."""
    news: News = field(default_factory=lambda: values.NO_NEWS)
    """Of every robot known to need the formation to wait, the newest word; the tick is where that plan begins."""
    way: Way = field(default_factory=lambda: values.NO_WAY)
    """The newest preview of the path that it knows; empty where every robot knows the path."""
    lost: Sender = 0
    """0, unless its preview is over or it is not back yet in the place that a newer one gives it: then the first robot
    in the ring of which it knows that it is lost, itself or one upstream."""
    number: Count = 0
    """Of the plans that the sender sent in this episode, from 0: a gap is a loss, a plan that was not sent is none."""
    __pydantic_config__ = STRICT

    @property
    def begins(self) -> float:
        """When the plan begins [s]."""
        return self.stamp + self.delay


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
    keeps_off: Sender = 0  # the robot that v and omega were changed for; 0 if they are the plan's
    failure: Text = ""
    """Of a user's own controller that has failed in this episode: what and where; v and omega are 0 then."""
    __pydantic_config__ = STRICT


@dataclass(frozen=True, slots=True, eq=False)
class Status:
    """Agent to displays, ten times a second: what it plans and believes, its link, its solver."""

    sender: Sender
    seq: Count
    stamp: NonNegative
    episode: Count
    link: Link
    """Name of the link from its upstream neighbour."""
    age: NonNegative
    """Age of the newest plan that arrived over it [s]."""
    plan: values.Motion | None
    """The newest plan that it sent; None before the first. Displays need no more of a plan."""
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
    keeps_off: Sender = 0
    """Both as in the Command of the same tick."""
    way_age: NonNegative = 0.0
    """Since robot 1 sent what this robot knows of the path [s]; 0 for a robot that knows the path itself."""
    lost: Flag = False
    lag: NonNegative = 0.0
    way: Way = field(default_factory=lambda: values.NO_WAY)
    """All three as in `plan`."""
    plan_bytes: Count = 0
    """Size of the message with `plan`; 0 if that is not known."""
    believes: values.Motion | None = None
    """What its controller was given of the neighbour upstream for its newest plan: that neighbour's own, carried on
    to where this one begins; without one, or past its end, the neighbour is taken to be in its slot."""
    __pydantic_config__ = STRICT


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
    contacts: Count
    """Pairs of robots that came to touch in this episode."""
    gap: Real
    """Least distance of two bodies in this episode [m]; negative if they overlapped."""
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
    driving: Driving = field(default_factory=Driving)  # the driver's orders, where the path is driven
    interventions: Count = 0
    """Number of interventions of users in this episode."""
    excursions: list[Excursion] = field(default_factory=list)
    """The newest, oldest first; those that go on, too."""
    excursion_count: Count = 0
    excursion_limit: NonNegative = 0.0
    """[m]."""
    pushes: list[Pushed] = field(default_factory=list)
    """Disturbances that act now."""
    resumed: list[Count] = field(default_factory=list)  # ticks at which its segments begin, but for the first
    away: list[Sender] = field(default_factory=list)  # robots over which the ring is closed
    record: RecordWish = ""  # of users
    recording: Recording | None = None
    """How the record stands; None while there is no recorder."""
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
    angle_errors: Numbers
    tracking_error: NonNegative
    """As in State."""
    __pydantic_config__ = STRICT


Message = (
    Tick
    | Plan
    | Command
    | Status
    | State
    | Stretch
    | Recording
    | Ghost
    | BodyInput
    | BodyPose
    | Setup
    | Request
    | Reply
)
