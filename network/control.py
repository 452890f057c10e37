"""The operations that a client may request of the world: one model each, named in a Request."""

from numbers import Real
from typing import Annotated, Any

from pydantic import Field, FiniteFloat, ValidationError

from formation.errors import EchelonError, unknown
from formation.faults import Fault
from formation.paths.driven import OrderedSpeed, OrderedTurn
from formation.schema import Duration, NonNegative
from formation.validation import problems
from network import topics
from network.fields import Link
from network.interventions import MAX_SECONDS, Join, Leave, Move, OperationModel, Push, Release, Reshape, Robot
from network.requests import Request
from network.values import Intervention

FARTHEST = 1e6
"""Of a goal [m]."""
FASTEST = 1000.0
"""Speed of a run [simulated seconds per second]."""
TRACE_ROWS = 40_000
"""Rows of one robot's trace in one reply, at most: 3 MB."""


def checked_speed(value: object, of: str = "speed") -> float:
    """A speed for a run: simulated seconds per second, 0 as fast as possible.

    Args:
        value: a number, one hopes.
        of: what the error names.

    Raises:
        EchelonError: it is none, or out of range.
    """
    if not isinstance(value, Real) or not 0.0 <= float(value) <= FASTEST:
        got = f"{value:g}" if isinstance(value, float) else repr(value)
        raise EchelonError(f"{of}: expected 0 (as fast as possible) to {FASTEST:g}; got {got}")
    return float(value)


class Start(OperationModel):
    """Start, or continue."""


class Pause(OperationModel):
    """Stop simulated time after the current tick."""


class Step(OperationModel):
    """Pause, then run this many ticks."""

    ticks: Annotated[int, Field(ge=1, le=100_000)] = 1


class Reset(OperationModel):
    """Start a new episode."""


class Speed(OperationModel):
    """Simulated seconds per second; 0 means as fast as possible."""

    speed: Annotated[NonNegative, Field(le=FASTEST)]


class SetFault(OperationModel):
    """Change keys of a link's fault, for some simulated time or until further notice."""

    link: str = "all"
    changes: dict[str, Any]
    """Keys of formation.faults.Fault."""
    seconds: Annotated[Duration, Field(gt=0.0)] | None = None


class SetPreset(OperationModel):
    """Give a link the fault of a preset."""

    link: str = "all"
    preset: str
    seconds: Annotated[Duration, Field(gt=0.0)] | None = None


class Clear(OperationModel):
    """Remove the faults that users set on a link, and end the scheduled ones that are active now."""

    link: str = "all"


class UseScenario(OperationModel):
    """Switch to another scenario."""

    scenario: str
    """A shipped name; of a `table` its own."""
    table: dict[str, Any] | None = None
    """The scenario itself instead, checked as a file is; it may name no files."""
    overrides: dict[str, Any] = Field(default_factory=dict)
    """What differs from it, such as {"link": {"latency": 0.3}}."""


class UseController(OperationModel):
    """Start the same scenario again with another controller."""

    controller: str


class Kill(OperationModel):
    """Have the launcher kill an agent (SIGKILL); it stays down until `Restart`."""

    robot: Robot


class Restart(OperationModel):
    """Have the launcher start a killed agent again, or replace a live one."""

    robot: Robot


class Compare(OperationModel):
    """Run a ghost beside the formation: the same scenario and faults under another controller."""

    controller: str
    """A name that the world knows, or "off"."""


class Record(OperationModel):
    """Have the launcher start a recorder, with a new file in the folder that the run was started from, or end it."""

    on: bool


class Stop(OperationModel):
    """End the run and its processes."""


class GetSetup(OperationModel):
    """Answered by a Setup instead of a Reply."""


class Drive(OperationModel):
    """Order a driven formation a speed and a turn rate, cut to what it can do."""

    v: OrderedSpeed
    """Speed of the centre; below 0 backwards [m/s]."""
    omega: OrderedTurn
    """Turn rate of the centre, counter-clockwise positive [rad/s]."""
    seconds: Annotated[Duration, Field(gt=0.0, le=MAX_SECONDS)] | None = None
    """Simulated time after which it slows to a stop; None: the order counts until the next one."""


class GoTo(OperationModel):
    """Drive the centre of a driven formation to a point, and stop there."""

    x: Annotated[FiniteFloat, Field(ge=-FARTHEST, le=FARTHEST)]
    """Of the point [m]."""
    y: Annotated[FiniteFloat, Field(ge=-FARTHEST, le=FARTHEST)]
    """Of the point [m]."""


class GetOrders(OperationModel):
    """The reply's value is an Orders: what repeats this episode so far, in parts."""

    tables: Annotated[int, Field(ge=0)] = 0
    """Number of fault tables to leave out, because the client has them."""
    drives: Annotated[int, Field(ge=0)] = 0
    """Number of drive orders to leave out, because the client has them."""
    interventions: Annotated[int, Field(ge=0)] = 0
    """Number of interventions to leave out, because the client has them."""


class Orders(OperationModel):
    """What users and the schedule did to an episode: fault tables, orders of its driver, interventions."""

    episode: int
    changes: int
    drive_changes: int
    """Number of tables and of drive orders in this episode so far; request again for those that are missing here."""
    tables: list[tuple[NonNegative, dict[Link, Fault]]]
    """Every link that is not perfect, from each stamp on. The first table of an episode is the one at t = 0."""
    drives: list[tuple[Annotated[int, Field(ge=0)], OrderedSpeed, OrderedTurn]]
    """Tick from which on it counts, v [m/s], omega [rad/s]."""
    intervention_changes: int = 0
    """Number of interventions in this episode so far."""
    interventions: list[Intervention] = Field(default_factory=list)
    resumed: list[Annotated[int, Field(ge=0)]] = Field(default_factory=list)
    """Ticks from which on the world went on from a saved state, and every agent began anew."""


class GetTrace(OperationModel):
    """The reply's value is a TraceRows: rows of the episode's trace."""

    first: Annotated[int, Field(ge=0)] = 0
    """Tick from which on rows are wanted; a reply has TRACE_ROWS of them at most, divided by the number of robots."""


class GetSummary(OperationModel):
    """The reply's value is the summary of the episode."""

    warmup: NonNegative = 0.0


Operation = (
    Start
    | Pause
    | Step
    | Reset
    | Speed
    | SetFault
    | SetPreset
    | Clear
    | UseScenario
    | UseController
    | Kill
    | Restart
    | Compare
    | Record
    | Stop
    | GetSetup
    | Drive
    | GoTo
    | Push
    | Move
    | Release
    | Reshape
    | Leave
    | Join
    | GetOrders
    | GetSummary
    | GetTrace
)
OPERATIONS: dict[str, type[Operation]] = {
    "start": Start,
    "pause": Pause,
    "step": Step,
    "reset": Reset,
    "speed": Speed,
    "fault": SetFault,
    "preset": SetPreset,
    "clear": Clear,
    "scenario": UseScenario,
    "controller": UseController,
    "kill": Kill,
    "restart": Restart,
    "compare": Compare,
    "record": Record,
    "stop": Stop,
    "setup": GetSetup,
    "drive": Drive,
    "goto": GoTo,
    "push": Push,
    "move": Move,
    "release": Release,
    "shape": Reshape,
    "leave": Leave,
    "join": Join,
    "orders": GetOrders,
    "summary": GetSummary,
    "trace": GetTrace,
}
QUESTIONS = frozenset({"setup", "orders", "summary", "trace"})
"""What changes nothing, so that anybody in the run may ask it."""
_NAMES = {model: name for name, model in OPERATIONS.items()}


def key(run: str, message: Request) -> str:
    """Where a request is to be asked."""
    return topics.question(run) if message.operation in QUESTIONS else topics.control(run)


def request(operation: Operation) -> Request:
    """The operation as a message."""
    return Request(_NAMES[type(operation)], operation.model_dump(exclude_unset=True))


def operation(message: Request) -> Operation:
    """The operation that a request names.

    Raises:
        EchelonError: there is no such operation, or its arguments are wrong; the text lists what there is.
    """
    model = OPERATIONS.get(message.operation)
    if model is None:
        raise EchelonError(unknown("operation", message.operation, OPERATIONS))
    try:
        return model.model_validate(message.arguments)
    except ValidationError as error:
        raise EchelonError("; ".join(problems(error, model))) from None
