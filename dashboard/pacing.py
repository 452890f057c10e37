"""How often the page is drawn, by the number of robots: a page without a graphics card could not follow more."""

from typing import NamedTuple


class Pace(NamedTuple):
    """Between two drawings [s]."""

    frame: float
    """Of the scene."""
    panels: float
    plots: float


PACES = (
    (8, Pace(1.0 / 30.0, 0.2, 0.25)),
    (20, Pace(1.0 / 30.0, 0.35, 0.35)),
    (64, Pace(1.0 / 18.0, 0.3, 0.4)),
    (256, Pace(1.0 / 10.0, 0.6, 0.8)),
)
"""Up to so many robots."""
CROWD = Pace(1.0 / 6.0, 1.5, 1.5)
"""Of more."""
UNWATCHED_FRAME, UNWATCHED_PAUSE = 0.5, 0.05
"""While no page is open: between two frames, and between two states that are kept for plots and export [s]."""


def pace(robots: int) -> Pace:
    """For a page of so many robots."""
    return next((pace for most, pace in PACES if robots <= most), CROWD)
