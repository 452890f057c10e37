"""What every reference path has, and its heading as the paper samples it."""

from typing import Any, ClassVar, Literal, Self

import numpy as np
from pydantic import model_validator

from formation.arrays import FloatArray
from formation.schema import Model


class Path(Model):
    """What every path has."""

    known_to: Literal["all", "leader"] = "all"
    """Who evaluates it: every robot, or robot 1 alone, whose preview the others pass on round the ring."""
    leader: Literal["fixed", "next"] = "fixed"
    """If robot 1 leaves the ring, which alone knew the path: the formation stops, or the next one in the ring leads."""
    wait_for_lost: bool = False
    """Whether all robots wait while one of them is not told the path any more; only with known_to = "leader"."""
    lengths: ClassVar[tuple[str, ...]] = ()
    """Keys that are lengths or speeds: a path with all of them twice as large is twice as large, in the same time."""

    @model_validator(mode="after")
    def _led(self) -> Self:
        if self.leader == "next" and self.known_to != "leader":
            raise ValueError('leader: expected known_to = "leader" for next; got all')
        return self

    @property
    def period(self) -> float | None:
        """Time after which the path repeats [s]; None for an open path."""
        return None

    @property
    def endless(self) -> bool:
        """Whether a live run may go on beyond the scenario's duration."""
        return self.period is not None

    @property
    def corners(self) -> tuple[tuple[float, float], ...]:
        """Where its heading jumps: times [s] and turns [rad], counter-clockwise positive."""
        return ()

    @property
    def smooth(self) -> bool:
        """Whether little happens within a fifth of a second, `corners` aside."""
        return True

    def larger(self, by: float) -> dict[str, Any]:
        """The path's table with all lengths multiplied."""
        given = self.model_dump(exclude_none=True)
        return {key: multiplied(value, by) if key in self.lengths else value for key, value in given.items()}

    def position(self, t: FloatArray) -> FloatArray:
        """Positions at times t [s], of shape t.shape + (2,) [m]. Defined for negative t too."""
        raise NotImplementedError


def heading(path: Path, t: FloatArray, interval: float) -> FloatArray:
    """Heading of the path as the paper samples it (below eq. 2): the direction of the last interval.

    theta_r(t) = atan2(p_r(t) - p_r(t - interval)) [rad], of the shape of t.
    """
    step = path.position(t) - path.position(t - interval)
    return np.arctan2(step[..., 1], step[..., 0])


def multiplied(value: Any, by: float) -> Any:
    """A number, or numbers in lists in lists, multiplied."""
    if isinstance(value, list | tuple):
        return [multiplied(one, by) for one in value]
    return by * value
