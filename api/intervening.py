"""What users do to the robots of an episode, be it in this process or in a live run."""

from abc import ABC, abstractmethod
from typing import Any

from api.arguments import plain
from formation.disturbances import Kind
from network.control import Operation, operation
from network.requests import Request


def order(name: str, arguments: dict[str, Any]) -> Operation:
    """The operation with these arguments. Raises EchelonError: one of them is wrong."""
    return operation(Request(name, plain(arguments)))


class Intervening(ABC):
    """Pushes robots and changes their formation, by the orders that the world validates."""

    @abstractmethod
    def _intervene(self, operation: Operation) -> None:
        """Have the world do it. Raises EchelonError."""

    def push(self, robot: int, kind: Kind, *, seconds: float | str | None = None) -> None:
        """Disturb a robot's body from the next tick on: gust, slow, stuck, slippery or blind.

        Args:
            robot: its number, from 1.
            kind: of the disturbance.
            seconds: for how long [s], or text such as "2s"; until `release`, if None.

        Raises:
            EchelonError: there is no such robot or kind, or a value is out of range.
        """
        self._intervene(order("push", {"robot": robot, "kind": kind, "seconds": seconds}))

    def move(self, robot: int, dx: float, dy: float) -> None:
        """Take a robot and carry it aside by (dx, dy) [m] within half a second. Raises EchelonError."""
        self._intervene(order("move", {"robot": robot, "dx": dx, "dy": dy}))

    def release(self, robot: int | None = None) -> None:
        """End what disturbs a robot, or all of them. Raises EchelonError."""
        self._intervene(order("release", {"robot": robot}))

    def leave(self, robot: int) -> None:
        """Take a robot out of the ring, which closes over it; it stands until `join`. Raises EchelonError."""
        self._intervene(order("leave", {"robot": robot}))

    def join(self, robot: int) -> None:
        """Take a robot that `leave` took out into the ring again. Raises EchelonError."""
        self._intervene(order("join", {"robot": robot}))

    def reshape(
        self, shape: str | None = None, *, spacing: float | None = None, over: float | str | None = None
    ) -> None:
        """Change the shape, the spacing, or both, from the next tick on.

        Args:
            shape: such as "line"; it stays, if None.
            spacing: between neighbours [m]; it stays, if None.
            over: how long the change takes [s], or text such as "2s"; derived from the path's speed, if None.

        Raises:
            EchelonError: this formation cannot take it.
        """
        self._intervene(order("shape", {"shape": shape, "spacing": spacing, "over": over}))
