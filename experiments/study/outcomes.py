"""What is measured of one flight, by name."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from pydantic import model_validator

from formation.arrays import FloatArray
from formation.links import LinkId
from formation.metrics import clearance
from formation.scenario.scenario import Scenario
from formation.schema import Duration, Model, Positive
from network.messages import LinkCounts
from world.trace import Trace


class Event(Model):
    """Something that upsets the formation for a while, and when the formation counts as recovered from it.

    The level is the RMS of l_e over the last `window` seconds, of the robot that is worst off at that moment.
    """

    at: Duration
    """When it begins [s]."""
    until: Duration
    """When it is over, and the time to recover begins [s]."""
    below: Positive | None = None
    """Recovered when the level is below this [m]."""
    factor: Positive | None = None
    """Or below this many times its highest value between the warm-up and `at`."""
    window: Duration = 0.0
    """[s]; 0 takes |l_e| as it is. It delays the level, so that no recovery looks faster than it was."""
    hold: Positive | None = None
    """How long it has to stay there [s]; to the end of the flight, if absent."""

    @model_validator(mode="after")
    def _sensible(self) -> "Event":
        if self.until <= self.at:
            raise ValueError(f"expected until > at; got until {self.until:g} and at {self.at:g}")
        if (self.below is None) == (self.factor is None):
            raise ValueError("expected either below or factor")
        return self


@dataclass(frozen=True, slots=True, eq=False)
class Record:
    """A flight as the measures see it: from the warm-up on."""

    times: FloatArray
    """(T,) [s]."""
    poses: FloatArray
    """(T, n, 3) [m, m, rad]."""
    distance: FloatArray
    """(T, n) l_e [m]."""
    angle: FloatArray
    """(T, n) psi_e [rad]."""
    tracking: FloatArray
    """(T,) distance of the robots' mean position to the path's point [m]."""
    ages: FloatArray
    """(T - 1, n) age of the plan that each robot acted on; NaN while there was none [s]."""
    counts: Mapping[LinkId, LinkCounts]
    """By link, of the whole flight."""
    level: FloatArray
    """(T,) the level of an `Event`, or |l_e| of the worst robot without one [m]."""
    event: Event | None


def record(
    scenario: Scenario, trace: Trace, counts: Mapping[LinkId, LinkCounts], warmup: float, event: Event | None
) -> Record:
    """The part of a flight that is measured.

    Args:
        scenario: what was flown.
        trace: the whole flight.
        counts: messages by link.
        warmup: measures start at this simulated time [s].
        event: what upsets the formation, if anything does.
    """
    first = min(len(trace.times) - 2, round(warmup / scenario.control_interval))
    distance, angle, tracking = trace.errors()
    window = max(1, round((event.window if event else 0.0) / scenario.control_interval))
    return Record(
        times=trace.times[first:],
        poses=trace.poses[first:],
        distance=distance[first:],
        angle=angle[first:],
        tracking=tracking[first:],
        ages=trace.ages[first:],
        counts=counts,
        level=trailing_rms(distance, window)[first:].max(axis=1),
        event=event,
    )


def trailing_rms(values: FloatArray, window: int) -> FloatArray:
    """RMS over the last `window` samples of values (T, n), fewer at the beginning: (T, n)."""
    if window <= 1:
        return np.abs(values)
    total = np.cumsum(np.vstack([np.zeros_like(values[:1]), values**2]), axis=0)
    end = np.arange(1, len(values) + 1)
    begin = np.maximum(0, end - window)
    mean = (total[end] - total[begin]) / (end - begin)[:, None]
    return np.sqrt(np.maximum(mean, 0.0))  # a difference of sums may round below zero


def recovery(flight: Record) -> float:
    """From the event's end until the level is below its threshold and stays there [s]; NaN if it never does."""
    event = flight.event
    assert event is not None  # a study without one cannot ask for it
    threshold = event.below or 0.0
    if event.factor is not None:
        before = flight.level[flight.times < event.at - 1e-9]
        threshold = event.factor * float(before.max(initial=0.0))
    after = flight.times >= event.until - 1e-9
    good, times = flight.level[after] < threshold, flight.times[after]
    bad = np.flatnonzero(~good)
    starts = np.concatenate([[0], bad + 1])  # of the stretches without a bad sample between two bad ones
    ends = np.concatenate([bad, [len(good)]])
    for start, end in zip(starts, ends, strict=True):
        last = end == len(good)
        if start < end and (last or (event.hold is not None and times[end] - times[start] >= event.hold)):
            return float(times[start] - event.until)
    return float("nan")


def event_max(flight: Record) -> float:
    """The largest |l_e| from the event's beginning on [m]."""
    assert flight.event is not None
    return float(np.abs(flight.distance[flight.times >= flight.event.at - 1e-9]).max())


def lost(flight: Record) -> float:
    """Share of the plans sent that were lost, over all links."""
    sent = sum(c.sent for c in flight.counts.values())
    return sum(c.lost for c in flight.counts.values()) / sent if sent else float("nan")


def _rms(values: FloatArray) -> FloatArray:
    return np.asarray(np.sqrt(np.mean(values**2, axis=0)))


@dataclass(frozen=True, slots=True)
class Measure:
    """One figure of a flight."""

    of: Callable[[Record], float]
    unit: str
    """SI, as in the tables."""
    words: str
    """What it is, for the axis of a figure."""
    of_event: bool = False
    """Whether it needs an event."""


MEASURES: dict[str, Measure] = {
    "distance_rms_m": Measure(lambda f: float(_rms(f.distance).max()), "m", "RMS of $l_e$, worst robot"),
    "distance_max_m": Measure(lambda f: float(np.abs(f.distance).max()), "m", "largest $|l_e|$"),
    "distance_final_m": Measure(lambda f: float(np.abs(f.distance[-1]).max()), "m", "final $|l_e|$, worst robot"),
    "angle_rms_rad": Measure(lambda f: float(_rms(f.angle).max()), "rad", r"RMS of $\psi_e$, worst robot"),
    "tracking_rms_m": Measure(lambda f: float(_rms(f.tracking)), "m", "RMS of centre to path"),
    "tracking_max_m": Measure(lambda f: float(f.tracking.max()), "m", "largest centre to path"),
    "tracking_final_m": Measure(lambda f: float(f.tracking[-1]), "m", "final centre to path"),
    "clearance_m": Measure(lambda f: clearance(f.poses), "m", "least gap of two robots"),
    "recovery_s": Measure(recovery, "s", "time to recover", of_event=True),
    "event_max_m": Measure(event_max, "m", "largest $|l_e|$ since the event", of_event=True),
    "age_median_s": Measure(lambda f: _age(f, 0.5), "s", "median age of the plans used"),
    "age_max_s": Measure(lambda f: _age(f, 1.0), "s", "largest age of a plan used"),
    "lost_share": Measure(lost, "1", "share of plans lost"),
}
"""Everything that a study can measure. Distances are of the worst robot, from the warm-up on."""


def _age(flight: Record, share: float) -> float:
    ages = flight.ages[np.isfinite(flight.ages)]
    return float(np.quantile(ages, share)) if ages.size else float("nan")
