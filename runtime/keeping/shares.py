"""Which robots' agents each of several equal keepers runs; each decides for itself, and all alike."""

from collections.abc import Iterable


class Shares:
    """The keepers of a run, as one of them sees them by their liveliness tokens."""

    def __init__(self, own: int) -> None:
        """Alone.

        Args:
            own: number of this keeper, which no other has.
        """
        self._own, self._keepers = own, {own}

    def note(self, keeper: int, *, here: bool) -> None:
        """A keeper has come or gone."""
        if keeper != self._own:
            (self._keepers.add if here else self._keepers.discard)(keeper)

    def of(self, robots: Iterable[int]) -> set[int]:
        """This keeper's part of these robots: with N keepers every Nth, in the order of the keepers' numbers."""
        rank = sorted(self._keepers).index(self._own)
        return {robot for robot in robots if (robot - 1) % len(self._keepers) == rank}
