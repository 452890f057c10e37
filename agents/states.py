"""The states of an AgentNode, as a table: what it does depends on its state and on what it finds, on nothing else."""

from enum import StrEnum


class State(StrEnum):
    """What the node waits for."""

    NEW = "the first Setup"
    IDLE = "the next tick"
    ASKING = "a Setup that fits the newest tick"
    BLOCKED = "the upstream neighbour's plan of the tick before"


class Event(StrEnum):
    """What the node finds when it looks at the newest tick and at what it has."""

    NOTHING = "there is no tick that is not answered"
    UNKNOWN = "the newest tick needs another Setup: another episode or revision, or it is too far ahead to be believed"
    LACKING = "the tick is understood, but the upstream neighbour's plan of the tick before is missing"
    READY = "everything is there"


class Output(StrEnum):
    """What the node does."""

    NONE = ""
    ASK = "send a request for the Setup, and again every ASK_SECONDS"
    ANSWER = "step the agent; publish its plan, then its command"


TABLE: dict[tuple[State, Event], tuple[State, Output]] = {
    (State.NEW, Event.NOTHING): (State.NEW, Output.ASK),
    (State.NEW, Event.UNKNOWN): (State.NEW, Output.ASK),
    (State.NEW, Event.LACKING): (State.BLOCKED, Output.NONE),
    (State.NEW, Event.READY): (State.IDLE, Output.ANSWER),
    (State.IDLE, Event.NOTHING): (State.IDLE, Output.NONE),
    (State.IDLE, Event.UNKNOWN): (State.ASKING, Output.ASK),
    (State.IDLE, Event.LACKING): (State.BLOCKED, Output.NONE),
    (State.IDLE, Event.READY): (State.IDLE, Output.ANSWER),
    (State.ASKING, Event.NOTHING): (State.IDLE, Output.NONE),
    (State.ASKING, Event.UNKNOWN): (State.ASKING, Output.ASK),
    (State.ASKING, Event.LACKING): (State.BLOCKED, Output.NONE),
    (State.ASKING, Event.READY): (State.IDLE, Output.ANSWER),
    (State.BLOCKED, Event.NOTHING): (State.IDLE, Output.NONE),
    (State.BLOCKED, Event.UNKNOWN): (State.ASKING, Output.ASK),
    (State.BLOCKED, Event.LACKING): (State.BLOCKED, Output.NONE),
    (State.BLOCKED, Event.READY): (State.IDLE, Output.ANSWER),
}
"""(state, event) -> (next state, output). The first Setup leads from NEW to IDLE, and makes the agent appear.

No state lasts unless the network does: the world repeats a tick that is not answered, and a request is repeated.
A tick that is repeated while it is the newest has the last answers sent again, in every state: somebody lacks one.
"""
