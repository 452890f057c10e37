"""The phases of a WorldNode, as a table: which follows on which event."""

from enum import StrEnum


class Phase(StrEnum):
    """What the node waits for. A tick is out in ASK, CALL and DRIVE."""

    HOLD = "something to simulate: live agents, a start, the next tick's time"
    ASK = "lockstep: the commands of every agent that was live when the tick went out; it is repeated"
    CALL = "lockstep: the command of anybody, for nobody is live; the tick is repeated"
    DRIVE = "real time: the end of the tick's wall-clock time"
    PACE = "lockstep: the next tick's wall-clock time"
    LAST = "the last statuses of the episode; its last tick is repeated"


class Event(StrEnum):
    """What leads to another phase."""

    ASKED = "lockstep: a tick went out to live agents"
    CALLED = "lockstep: a tick went out although nobody is live"
    DRIVEN = "real time: a tick went out"
    COMPLETE = "the tick has its commands; the world has moved on"
    DUE = "it is time for the next tick"
    FINISHED = "the episode has reached its duration"
    GATHERED = "every live agent's last status is there, or was waited for long enough"
    ABANDONED = "another episode or scenario began while the tick was out"


TABLE: dict[tuple[Phase, Event], Phase] = {
    (Phase.HOLD, Event.ASKED): Phase.ASK,
    (Phase.HOLD, Event.CALLED): Phase.CALL,
    (Phase.HOLD, Event.DRIVEN): Phase.DRIVE,
    (Phase.ASK, Event.COMPLETE): Phase.PACE,
    (Phase.ASK, Event.ABANDONED): Phase.HOLD,
    (Phase.CALL, Event.COMPLETE): Phase.PACE,
    (Phase.CALL, Event.ABANDONED): Phase.HOLD,
    (Phase.DRIVE, Event.COMPLETE): Phase.HOLD,
    (Phase.DRIVE, Event.FINISHED): Phase.LAST,
    (Phase.DRIVE, Event.ABANDONED): Phase.HOLD,
    (Phase.PACE, Event.DUE): Phase.HOLD,
    (Phase.PACE, Event.FINISHED): Phase.LAST,
    (Phase.PACE, Event.ABANDONED): Phase.HOLD,
    (Phase.LAST, Event.GATHERED): Phase.HOLD,
}
"""(phase, event) -> next phase; any other pair is a mistake of the node. Queries are answered in every phase.

Operations are carried out in every phase but LAST. Those that change what a tick means for who answers it
(run_control.BETWEEN_TICKS) wait until none is out, or are refused when that takes long.
"""

SKIPPED = 1 << 20
"""Numbers that a world skips when it goes on from a saved state: the process before may have used them since."""
OUT = {Phase.ASK, Phase.CALL, Phase.DRIVE}
"""A tick is out."""
