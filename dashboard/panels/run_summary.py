"""The summary at the top of the left panel: the run's condition, three numbers, and the strip of robots."""

from typing import NamedTuple

from dashboard.panels.hops import hops, oldest_way
from dashboard.telemetry.beliefs import BeliefView
from dashboard.telemetry.links import LOST_SECONDS, LinkView, oldest
from dashboard.telemetry.snapshot import Snapshot
from dashboard.theme.formatting import duration, error, length
from dashboard.theme.limits import DISTANCE_LIMIT, LAG_LIMIT
from dashboard.theme.templates import render
from network.messages import State, Status


class Condition(NamedTuple):
    """How the run is."""

    label: str
    """In a word."""
    colour: str
    """Name of the colour of its pill, of the dark theme: ok, warn, bad or muted."""
    note: str
    """A sentence more, or empty."""


class Tile(NamedTuple):
    """One of the three numbers."""

    label: str
    number: str
    unit: str
    level: float
    """0 is healthy, 1 the limit."""


REWOUND = Condition("REWOUND", "warn", "Buttons and sliders show the run as it is, and act now.")
RECORD = Condition("RECORD", "muted", "What was done cannot be changed: controls that would change it are off.")


def run_summary(
    snapshot: Snapshot, links: list[LinkView], beliefs: list[BeliefView], shown: Condition | None = None
) -> str:
    """HTML of the run's condition, its time, the three numbers and the strip of robots.

    Args:
        snapshot: of the run, or of a moment of its past.
        links: of the ring, then.
        beliefs: of its robots, then.
        shown: in place of the run's condition.
    """
    state = snapshot.state
    return render(
        "panels/run_summary.html",
        condition=shown or condition(snapshot),
        state=state,
        world_alive=snapshot.world_alive,
        gap="" if state is None else " ".join(length(state.gap)),
        off_path="" if state is None else " ".join(error(state.tracking_error, snapshot.noise)),
        tiles=[] if state is None else _tiles(snapshot, state, links, beliefs),
        strip=hops(snapshot, links),
    )


def condition(snapshot: Snapshot) -> Condition:
    """How the run is, as far as the page knows."""
    state = snapshot.state
    if not snapshot.connected:
        return Condition("NO ROUTER", "bad", "The run's router cannot be reached. This page reconnects by itself.")
    if state is None:
        return Condition("WAITING", "warn", "Waiting for the first state of this run's world.")
    if not snapshot.world_alive:
        return Condition("NO WORLD", "bad", "The world publishes nothing; the page shows its last state and waits.")
    if state.status == "waiting":
        robots = ", ".join(str(robot) for robot in state.waiting_for) or "…"
        return Condition("WAITING", "warn", f"Waiting for the agents of robots {robots}.")
    if state.status == "finished":
        return Condition("FINISHED", "muted", "The episode is over. Restart begins a new one.")
    note, behind = "", max((lag(status, state) for status in snapshot.statuses.values()), default=0.0)
    if behind > LAG_LIMIT:
        number, unit = duration(behind)
        note = f"The robots wait for one another, {number} {unit} behind the clock; rings mark where they should be."
    if state.waiting_for:
        note = "No agent for robots " + ", ".join(map(str, state.waiting_for)) + ": they stand still."
    return Condition("RUNNING", "ok", note) if state.status == "running" else Condition("PAUSED", "warn", note)


def lag(status: Status | None, state: State) -> float:
    """How far a robot is behind the clock by its newest plan [s]; 0 without one of this episode."""
    return status.lag if status is not None and status.episode == state.episode else 0.0


def _tiles(snapshot: Snapshot, state: State, links: list[LinkView], beliefs: list[BeliefView]) -> list[Tile]:
    """Is it together, is true what they believe, and how old is what they know?"""
    noise, distance, off = (
        snapshot.noise,
        float(abs(state.distance_errors).max()),
        max((one.error for one in beliefs), default=0.0),
    )
    way = oldest_way(snapshot)
    label, age = ("PLAN AGE", oldest(links)) if way is None else ("WAY AGE", way)
    return [
        Tile("FORMATION", *error(distance, noise), distance / DISTANCE_LIMIT),
        Tile("BELIEF", *error(off, noise), off / DISTANCE_LIMIT),
        Tile(label, *duration(age), age / LOST_SECONDS),
    ]
