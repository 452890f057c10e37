"""Who takes part in the ring: by the scenario, by users, and by the patience with agents that are gone."""

from collections.abc import Collection, Iterable

from formation.errors import EchelonError
from formation.scenario.membership import LEAST
from formation.scenario.scenario import Scenario


class Members:
    """The robots that are away in one episode, each with the reason; `look` is called once a tick."""

    def __init__(self, scenario: Scenario) -> None:
        self._size, self._tick = scenario.size, scenario.control_interval
        self._plan, self._patience = scenario.membership, scenario.membership.patience
        self._changes = bool(self._plan.changes)
        self._scheduled: frozenset[int] = frozenset()
        self._asked: set[int] = set()
        """Away because a user wanted it."""
        self._lost: set[int] = set()
        """Away because their agents were gone for too long."""
        self._gone_at: dict[int, int] = {}
        """Since which tick there is no agent."""
        self._repeats = False
        self.away: frozenset[int] = frozenset()
        """Robots that are not in the ring."""

    def look(self, k: int, live: Collection[int]) -> None:
        """It is tick k, and these robots have an agent: who is away follows in `away`."""
        if self._repeats:
            return
        scheduled = self._plan.away(k * self._tick) if self._changes else self._scheduled
        if scheduled == self._scheduled and len(live) == self._size and not (self._lost or self._gone_at):
            return
        self._scheduled = scheduled
        gone = set(range(1, self._size + 1)).difference(live) if live else set()  # nobody is here: the run waits
        self._gone_at = {robot: self._gone_at.get(robot, k) for robot in gone}
        self._lost &= gone
        for robot in sorted(gone - self._lost):
            if self._patience and (k - self._gone_at[robot]) * self._tick >= self._patience - 1e-9 and self._room():
                self._lost.add(robot)
        self._count()

    def leave(self, robot: int) -> None:
        """A user wants a robot out of the ring. Raises EchelonError: it is out, or too few would stay."""
        self._check(robot)
        if robot in self.away:
            raise EchelonError(f"expected a robot of the ring; robot {robot} has left it")
        if not self._room():
            raise EchelonError(f"expected at least {LEAST} robots that stay in the ring")
        self._asked.add(robot)
        self._count()

    def join(self, robot: int) -> None:
        """A user wants a robot back. Raises EchelonError: it is in the ring, or away for another reason."""
        self._check(robot)
        if robot not in self._asked:
            why = "its agent is gone" if robot in self._lost else "the scenario has it so"
            raise EchelonError(
                f"robot {robot} is away: {why}" if robot in self.away else f"robot {robot} is in the ring already"
            )
        self._asked.discard(robot)
        self._count()

    def impose(self, away: Iterable[int]) -> None:
        """Exactly these are away: this world repeats another's."""
        self._repeats, self.away = True, frozenset(away)

    def _check(self, robot: int) -> None:
        if robot > self._size:
            raise EchelonError(f"robot: expected 1 to {self._size}; got {robot}")

    def _room(self) -> bool:
        return self._size - len(self._scheduled | self._asked | self._lost) > LEAST

    def _count(self) -> None:
        self.away = self._scheduled | self._asked | self._lost
