"""The [estimator] table of a scenario."""

from typing import Annotated, Literal

from pydantic import Field

from formation.bodies.nominal import ticks_late
from formation.schema import Duration, Model, NonNegative


class Estimator(Model):
    """What an agent makes of measurements, before any controller sees them (docs/theory.md, section 12)."""

    enabled: bool = True
    """Filter measurements; without, a controller gets the newest measured pose, carried on along odometry."""
    disturbances: bool = True
    """Detect and estimate disturbances of the body velocity, and compensate for them."""
    doubt: NonNegative = 0.0
    """Of a drift across the heading so many standard deviations are taken for noise [1]; 0: all of it is believed."""
    relative: bool = True
    """Use relative sensing, where the bodies have it."""
    window: Annotated[int, Field(ge=1, le=3)] = 2
    """Robots in one filter: the own one, the upstream neighbour, and that one's (where robots see each other)."""
    delay: Duration | Literal["learn", "nominal"] = "learn"
    """From a command to its effect [s]: learnt, that of [bodies], or a number, of at most 1000 ticks."""
    lag: Duration | Literal["learn", "nominal"] = "nominal"
    """Time constant of the wheels [s], likewise."""

    def ticks_late(self, dt: float) -> int | None:
        """The delay in ticks of dt [s]; None if it is no number. Raises ValueError: it is too large."""
        return None if isinstance(self.delay, str) else ticks_late("estimator.delay", self.delay, dt)
