"""What users ask of a run: taken in order, carried out when it can be, answered."""

from collections import deque

from formation.errors import EchelonError, WireError
from network import control, topics
from network.bus import Action, Query, Reject, Respond
from network.codec import decode, encode
from network.control import Operation
from network.requests import Reply, Request
from world.run_control import BETWEEN_TICKS, RunControl
from world.world import World

HELD_SECONDS = 1.0
"""An operation that must wait for the end of a tick is refused after this long [s]: the one who asks waits little."""


class Requests:
    """The operations that wait."""

    def __init__(self, world: World, run_control: RunControl) -> None:
        self._world, self._control = world, run_control
        self._waiting: deque[tuple[Operation, Query, float]] = deque()
        """With the time since when."""
        self.actions: list[Action] = []
        """What is to be done; whoever reads it clears it."""

    def __bool__(self) -> bool:
        return bool(self._waiting)

    def receive(self, query: Query, now: float) -> None:
        """A query came in; one for the Setup is answered at once, for agents need it to answer this very tick."""
        try:
            request = decode(Request, query.payload)
            if topics.topic_of(query.key) is topics.QUESTION and request.operation not in control.QUESTIONS:
                raise EchelonError(f"expected a question; got {request.operation!r:.40}, which is an order")
            operation = control.operation(request)
        except EchelonError as error:
            if isinstance(error, WireError):
                self.actions.append(Reject("control", str(error)))
            self._reply(query, Reply(False, str(error)))
            return
        if isinstance(operation, control.GetSetup):
            self.actions.append(Respond(query, encode(self._world.setup())))
        else:
            self._waiting.append((operation, query, now))

    def carry_out_one(self, now: float, *, tick_is_out: bool) -> bool:
        """Do the next operation, if it can be done now; what changes holds from the next tick on, for everybody.

        Args:
            now: time [s].
            tick_is_out: whether agents are answering a tick; some operations must wait for its end.

        Returns:
            Whether one was carried out or refused.
        """
        if not self._waiting:
            return False
        operation, query, since = self._waiting[0]
        if not (tick_is_out and isinstance(operation, BETWEEN_TICKS)):
            self._reply(query, self._carry_out(operation))
        elif now - since >= HELD_SECONDS:
            self._reply(query, Reply(False, "cannot be done now: the run waits for an agent that does not answer"))
        else:
            return False
        self._waiting.popleft()
        return True

    def _carry_out(self, operation: Operation) -> Reply:
        try:
            return Reply(True, value=self._control.obey(operation))
        except EchelonError as error:
            return Reply(False, str(error))
        except (ArithmeticError, MemoryError, ValueError) as error:  # no request may end the world
            return Reply(False, f"cannot be done: {type(error).__name__} {error}")

    def _reply(self, query: Query, reply: Reply) -> None:
        self.actions.append(Respond(query, encode(reply)))
