"""What can be measured of one trial, by name."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np
from pydantic import model_validator

from experiments.metrics import recovery, trailing_rms
from formation.arrays import FloatArray
from formation.link_ids import LinkId
from formation.metrics import clearance, quantile, rms
from formation.scenario.scenario import Scenario
from formation.schema import Duration, Model, Positive
from network.values import Excursion, LinkCounts
from world.measures.contacts import Contacts
from world.measures.trace import Trace


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
    """How long it has to stay there [s]; to the end of the trial, if absent."""

    @model_validator(mode="after")
    def _sensible(self) -> "Event":
        if self.until <= self.at:
            raise ValueError(f"expected until > at; got until {self.until:g} and at {self.at:g}")
        if (self.below is None) == (self.factor is None):
            raise ValueError("expected either below or factor")
        return self


@dataclass(frozen=True, slots=True, eq=False)
class Record:
    """A trial as the measures see it: from the warm-up on."""

    times: FloatArray
    """(T,) [s]."""
    poses: FloatArray
    """(T, n, 3) [m, m, rad]."""
    distance: FloatArray
    """(T, n) l_e [m]; NaN while a robot is not in the ring."""
    angle: FloatArray
    """(T, n) psi_e [rad]; NaN likewise."""
    tracking: FloatArray
    """(T,) distance of the robots' mean position to the path's point [m]."""
    ages: FloatArray
    """(T - 1, n) age of the plan that each robot acted on; NaN while there was none [s]."""
    counts: tuple[LinkCounts, ...]
    """One per link, of the whole trial."""
    level: FloatArray
    """(T,) the level of an `Event`, or |l_e| of the worst robot without one [m]."""
    event: Event | None
    radii: tuple[float, ...] = ()
    """Of the robots [m]."""
    inputs: FloatArray = field(default_factory=lambda: np.zeros((0, 0, 2)))
    """(T - 1, n, 2) commanded v and omega [m/s, rad/s]."""
    duration: float = 0.0
    """Of the whole trial [s]."""
    plan_bytes: int = 0
    """Length of all plans that were sent in the whole trial [B]; 0 unless a measure asks for it."""
    excursions: tuple[Excursion, ...] = ()
    """The ledger of the whole trial."""


def record(
    scenario: Scenario,
    trace: Trace,
    counts: Mapping[LinkId, LinkCounts],
    warmup: float,
    event: Event | None,
    *,
    plan_bytes: int = 0,
    excursions: tuple[Excursion, ...] = (),
) -> Record:
    """The part of a trial that is measured.

    Args:
        scenario: what was simulated.
        trace: the whole trial.
        counts: messages by link.
        warmup: measures start at this simulated time [s].
        event: what upsets the formation, if anything does.
        plan_bytes: length of all plans [B].
        excursions: the ledger.
    """
    first = min(len(trace.times) - 2, round(warmup / scenario.control_interval))
    distance, angle, tracking = trace.errors()
    level, there = distance, trace.present
    if not there.all():
        distance, angle = np.where(there, distance, np.nan), np.where(there, angle, np.nan)
    window = max(1, round((event.window if event else 0.0) / scenario.control_interval))
    return Record(
        times=trace.times[first:],
        poses=trace.poses[first:],
        distance=distance[first:],
        angle=angle[first:],
        tracking=tracking[first:],
        ages=trace.ages[first:],
        counts=tuple(counts.values()),
        level=trailing_rms(level, window)[first:].max(axis=1),
        event=event,
        radii=tuple(scenario.bodies.radii(scenario.size)),
        inputs=trace.inputs[first:],
        duration=float(trace.times[-1]),
        plan_bytes=plan_bytes,
        excursions=excursions,
    )


def _pooled(errors: FloatArray) -> float:
    """RMS over all robots while they were in the ring."""
    return float(rms(errors[np.isfinite(errors)])) if np.isnan(errors).any() else rms(errors.ravel())


def _worst(errors: FloatArray) -> float:
    """RMS of the robot whose is largest, each while it was in the ring."""
    if not np.isnan(errors).any():
        return float(rms(errors, axis=0).max())
    return max(_pooled(column) for column in errors.T if np.isfinite(column).any())


def _recovery(trial: Record) -> float | None:
    """From the event's end until the level is below its threshold and stays there [s]."""
    event = trial.event
    assert event is not None  # a study without one cannot ask for it
    below = event.below or 0.0
    if event.factor is not None:
        before = trial.level[trial.times < event.at - 1e-9]
        below = event.factor * float(before.max(initial=0.0))
    return recovery(trial.times, trial.level, below=below, since=event.until, hold=event.hold)


def _event_max(trial: Record) -> float:
    """The largest |l_e| from the event's beginning on [m]."""
    assert trial.event is not None
    return float(np.nanmax(np.abs(trial.distance[trial.times >= trial.event.at - 1e-9])))


def _peak(trial: Record) -> float:
    """Of all excursions [m]; 0 without one."""
    return max((one.peak for one in trial.excursions), default=0.0)


def _slowest(trial: Record) -> float | None:
    """The longest time that an excursion took to recover [s]; None if one goes on, 0 without one."""
    if any(one.recovery is None for one in trial.excursions):
        return None
    return max((one.recovery or 0.0 for one in trial.excursions), default=0.0)


def _contacts(trial: Record) -> Contacts:
    """Who touched whom."""
    found = Contacts(trial.radii)
    for poses in trial.poses:
        found.look(poses)
    return found


def _lost(trial: Record) -> float | None:
    """Share of the plans sent that were lost, over all links."""
    sent = sum(c.sent for c in trial.counts)
    return sum(c.lost for c in trial.counts) / sent if sent else None


def _jitter(trial: Record) -> float:
    """RMS over robots and ticks of the commanded v's change [m/s]."""
    return rms(np.diff(trial.inputs[:, :, 0], axis=0).ravel())


def _plan_rate(trial: Record) -> float:
    """Plans that a robot sends in a second."""
    return sum(c.sent for c in trial.counts) / (trial.duration * len(trial.counts))


def _byte_rate(trial: Record) -> float:
    """Bytes of plans that a robot sends in a second."""
    robots: int = trial.distance.shape[1]
    return trial.plan_bytes / (trial.duration * robots)


@dataclass(frozen=True, slots=True)
class Measure:
    """One number of a trial."""

    of: Callable[[Record], float | None]
    """None where there is no value, such as a recovery that never came."""
    unit: str
    """SI, as in the tables."""
    label: str
    """What it is, for the axis of a figure."""
    of_event: bool = False
    """Whether it needs an event."""


BYTES = "bytes_per_s"
"""The measure that needs every plan's bytes."""
MEASURES: dict[str, Measure] = {
    "distance_rms_m": Measure(lambda t: _worst(t.distance), "m", "RMS of $l_e$, worst robot"),
    "distance_pooled_m": Measure(lambda t: _pooled(t.distance), "m", "RMS of $l_e$, all robots"),
    "distance_max_m": Measure(lambda t: float(np.nanmax(np.abs(t.distance))), "m", "largest $|l_e|$"),
    "distance_final_m": Measure(lambda t: float(np.nanmax(np.abs(t.distance[-1]))), "m", "final $|l_e|$, worst robot"),
    "angle_rms_rad": Measure(lambda t: _worst(t.angle), "rad", r"RMS of $\psi_e$, worst robot"),
    "tracking_rms_m": Measure(lambda t: rms(t.tracking), "m", "RMS of centre to path"),
    "tracking_max_m": Measure(lambda t: float(t.tracking.max()), "m", "largest centre to path"),
    "tracking_final_m": Measure(lambda t: float(t.tracking[-1]), "m", "final centre to path"),
    "clearance_m": Measure(lambda t: clearance(t.poses), "m", "least distance of two centres"),
    "gap_m": Measure(lambda t: _contacts(t).gap, "m", "least gap of two robots"),
    "contacts": Measure(lambda t: float(_contacts(t).count), "pairs", "pairs that came to touch"),
    "excursions": Measure(lambda t: float(len(t.excursions)), "times", "excursions of a robot's error"),
    "excursion_peak_m": Measure(_peak, "m", "largest excursion"),
    "excursion_recovery_s": Measure(_slowest, "s", "longest recovery from an excursion"),
    "recovery_s": Measure(_recovery, "s", "time to recover", of_event=True),
    "event_max_m": Measure(_event_max, "m", "largest $|l_e|$ since the event", of_event=True),
    "age_median_s": Measure(lambda t: quantile(t.ages, 0.5), "s", "median age of the plans used"),
    "age_max_s": Measure(lambda t: quantile(t.ages, 1.0), "s", "largest age of a plan used"),
    "jitter_mps": Measure(_jitter, "m/s", "RMS change of the commanded v per tick"),
    "plans_per_s": Measure(_plan_rate, "1/s", "plans that a robot sends"),
    BYTES: Measure(_byte_rate, "B/s", "bytes of plans that a robot sends"),
    "lost_share": Measure(_lost, "1", "share of plans lost"),
}
"""Everything that a study can measure. Distances are of the worst robot, from the warm-up on."""


def measured(names: tuple[str, ...], trial: Record) -> dict[str, float | None]:
    """The named measures of a trial; None where there is no finite value."""
    found = {name: MEASURES[name].of(trial) for name in names}
    return {name: value if value is not None and math.isfinite(value) else None for name, value in found.items()}
