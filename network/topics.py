"""The topics of a run, in one table: key, message, sender, rate, reliability, what is recorded.

Key expressions, the names in network/codec.py, staleness limits and the manual's table (docs/topics_table.py) follow
from it. A new topic is a line of TOPICS and a message in network/messages.py.
"""

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, Literal

from formation.schema import MAX_ROBOTS
from network.bodies import BodyInput, BodyPose
from network.messages import Command, Ghost, Plan, State, Status, Tick
from network.requests import Reply, Request, Setup
from network.stretch import Recording, Stretch
from network.values import Mode

Role = Literal[
    "router",
    "world",
    "agent",
    "ghost",
    "dashboard",
    "launcher",
    "keeper",
    "recorder",
    "body",
    "display",
    "operator",
    "observer",
    "each",
]
ROOT = "echelon"
LONGEST_NUMBER = len(str(MAX_ROBOTS))
"""Digits of a robot in a key."""


@dataclass(frozen=True, slots=True)
class Topic:
    """One key expression, and what goes over it."""

    name: str
    """Last part of the key, where there is one message."""
    path: str
    """Key below echelon/{run}, with {id} for the sender's number, {role} for its role and {session} for its session."""
    messages: tuple[type[Any], ...]
    """What is published; of a query the question, then the possible answers."""
    sender: Role
    """Role of the publisher; of a query, of the process that answers."""
    carries: str
    """In a few words, for readers."""
    rate: float | None = None
    """Messages a second of wall clock; None: with the ticks, or when asked."""
    pace: str = ""
    """The rate in words, where it is no number or holds at times only."""
    reliable: Literal["always", "lockstep", "never"] = "never"
    """When a publisher waits for a slow subscriber rather than drop: in every mode, in lockstep, or never."""
    stale: float = math.inf
    """Silent for longer, the sender counts as gone [s of wall clock]."""
    recorded: bool = False
    """Whether it goes into a record of the run."""

    def key(self, run: str, number: int | str = "*", role: str = "*", session: str = "*") -> str:
        """The key expression of a run, of one sender or (with "*") of all."""
        return f"{ROOT}/{run}/" + self.path.format(id=number, role=role, session=session)

    def is_reliable(self, mode: Mode) -> bool:
        """Whether a publisher waits for a slow subscriber in a run of this mode."""
        return self.reliable in ("always", mode)

    @property
    def published(self) -> bool:
        """Whether its messages are published, and not asked for."""
        return bool(self.messages) and self.messages[0] is not Request

    @property
    def interval(self) -> float:
        """Between two messages [s of wall clock]."""
        if self.rate is None:
            raise ValueError(f"expected a topic with a rate; got {self.name}")
        return 1.0 / self.rate


TICK = Topic(
    "tick",
    "tick",
    (Tick,),
    "world",
    "k, stamp, odometry and measurements, who has planned, revision of faults and scenario",
    pace="each control interval",
    reliable="lockstep",
    recorded=True,
)
PLAN = Topic(
    "plan",
    "robot/{id}/plan",
    (Plan,),
    "agent",
    "pose, body velocities over the horizon, delay, estimated disturbance, raw measurements, who needs the others to "
    "wait",
    pace="each planning tick",
    reliable="lockstep",
    recorded=True,
)
COMMAND = Topic(
    "command",
    "robot/{id}/command",
    (Command,),
    "agent",
    "v, omega, age of the plan used, solve time, whether the solver converged",
    pace="each tick",
    reliable="lockstep",
    recorded=True,
)
STATUS = Topic(
    "status",
    "robot/{id}/status",
    (Status,),
    "agent",
    "its newest plan, the newest that it received, age and counts of its link, solve time, Nash gap",
    rate=10.0,
    reliable="lockstep",
    stale=0.25,
    recorded=True,
)
STATE = Topic(
    "state",
    "state",
    (State,),
    "world",
    "poses, slots, errors, faults, events",
    rate=20.0,
    stale=1.5,
    recorded=True,
)
STRETCH = Topic(
    "stretch",
    "stretch",
    (Stretch,),
    "world",
    "true poses and inputs of every tick, orders, events, scenario",
    pace="20 Hz of simulated time while recording",
    reliable="lockstep",
    recorded=True,
)
RECORDING = Topic(
    "recording",
    "recording",
    (Recording,),
    "recorder",
    "file, size and time of the record",
    pace="each chunk of the record",
)
GHOST = Topic(
    "ghost",
    "ghost",
    (Ghost,),
    "ghost",
    "poses and errors of the compared controller at a State's stamp",
    rate=20.0,
    pace="20 Hz while comparing",
)
BODY_INPUT = Topic(
    "body_input",
    "robot/{id}/body_input",
    (BodyInput,),
    "world",
    "to the body of a real robot: v, omega that it acts on",
    pace="each tick, of real robots",
)
BODY_POSE = Topic(
    "body_pose",
    "robot/{id}/body_pose",
    (BodyPose,),
    "body",
    "where a real robot is, and how fast",
    pace="as the robot says it",
)
CONTROL = Topic("control", "control", (Request, Reply), "world", "orders", pace="on demand")
QUESTION = Topic("question", "question", (Request, Reply, Setup), "world", "what changes nothing", pace="on demand")
ASKERS: tuple[Role, ...] = ("dashboard", "operator")
"""Who gives orders; anybody in the run may ask questions."""
ALIVE = Topic("alive", "alive/{role}/{id}/{session}", (), "each", "liveliness token", pace="-")

TOPICS = (
    TICK,
    PLAN,
    COMMAND,
    STATUS,
    STATE,
    STRETCH,
    RECORDING,
    GHOST,
    BODY_INPUT,
    BODY_POSE,
    CONTROL,
    QUESTION,
    ALIVE,
)
OF_AGENTS = (PLAN, COMMAND, STATUS)
MESSAGES: dict[str, type[Any]] = {kind.__name__.lower(): kind for topic in TOPICS for kind in topic.messages}
"""Every message by its name on the wire."""


def tick(run: str) -> str:
    """The world's Tick."""
    return TICK.key(run)


def plan(run: str, robot: int | str) -> str:
    """An agent's Plan."""
    return PLAN.key(run, robot)


def command(run: str, robot: int | str) -> str:
    """An agent's Command."""
    return COMMAND.key(run, robot)


def status(run: str, robot: int | str) -> str:
    """An agent's Status."""
    return STATUS.key(run, robot)


def state(run: str) -> str:
    """The world's State, for displays."""
    return STATE.key(run)


def stretch(run: str) -> str:
    """The world's Stretch, for recorders."""
    return STRETCH.key(run)


def recording(run: str) -> str:
    """The recorder's Recording."""
    return RECORDING.key(run)


def ghost(run: str) -> str:
    """The same episode under another controller: Ghost."""
    return GHOST.key(run)


def body_input(run: str, robot: int | str) -> str:
    """What a real robot is to do: BodyInput."""
    return BODY_INPUT.key(run, robot)


def body_pose(run: str, robot: int | str) -> str:
    """Where a real robot is: BodyPose."""
    return BODY_POSE.key(run, robot)


def control(run: str) -> str:
    """The queryable on which the world takes orders."""
    return CONTROL.key(run)


def question(run: str) -> str:
    """The queryable on which the world answers what changes nothing."""
    return QUESTION.key(run)


def alive(run: str, role: str, number: int | str, session: str) -> str:
    """The liveliness token of a process; another process in its place has another session."""
    return ALIVE.key(run, number, role, session)


def topic_of(key: str) -> Topic | None:
    """The topic of a key without wildcards; None if there is none."""
    parts = key.split("/")
    return next((topic for topic in TOPICS if _fits(topic, parts)), None)


def _fits(topic: Topic, parts: list[str]) -> bool:
    expected = topic.path.split("/")
    return (
        len(parts) == 2 + len(expected)
        and parts[0] == ROOT
        and all(part == got or part.startswith("{") for part, got in zip(expected, parts[2:], strict=True))
    )


@lru_cache(maxsize=1024)
def robot_of(key: str) -> int | None:
    """The robot in a key `.../robot/{id}/...`; None if there is none."""
    parts = key.split("/")
    if len(parts) != 5 or parts[2] != "robot":
        return None
    text = parts[3]
    return int(text) if text.isascii() and text.isdigit() and len(text) <= LONGEST_NUMBER else None
