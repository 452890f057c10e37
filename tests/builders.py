"""Messages for tests: whole ones, of which a test names only what it is about."""

from dataclasses import replace
from typing import Any

import numpy as np

from formation.arrays import FloatArray
from formation.link_ids import LinkId
from network.messages import WORLD, Command, Plan, State, Status, Tick
from network.values import NO_PLACES, Event, LinkCounts, Motion

TICK = 0.01
"""Control interval of every shipped scenario [s]."""


def plan(sender: int, seq: int, episode: int = 0, **changes: Any) -> Plan:
    """A plan of tick `seq`."""
    whole = Plan(sender, seq, TICK * seq, episode, np.array([1.0, 2.0, 0.5]), 0.1, np.full((20, 2), 0.1))
    return replace(whole, **changes)


def motion(seq: int = 100, **changes: Any) -> Motion:
    """What a Status has of the plan of tick `seq`."""
    whole = plan(1, seq)
    return replace(Motion(whole.begins, whole.pose, whole.interval, whole.inputs), **changes)


def tick(k: int, poses: FloatArray, *, odometry: FloatArray | None = None, **changes: Any) -> Tick:
    """Tick k, at which localisation delivers the poses (n, 3) of all robots at once."""
    n = len(poses)
    whole = Tick(
        sender=WORLD,
        seq=k,
        stamp=TICK * k,
        episode=0,
        revision=0,
        odometry=np.zeros((n, 2)) if odometry is None else odometry,
        planned=[],
        measured=k,
        poses=poses,
        localised=list(range(1, n + 1)),
        relatives=NO_PLACES,
    )
    return replace(whole, **changes)


def command(sender: int, seq: int, v: float = 0.1, omega: float = 0.2, **changes: Any) -> Command:
    """A command for tick `seq`."""
    whole = Command(sender, seq, TICK * seq, 0, v, omega, age=0.01, planned=True, solve=1e-4)
    return replace(whole, **changes)


def status(sender: int, upstream: int, **changes: Any) -> Status:
    """A status without plans, at 1 s."""
    whole = Status(
        sender=sender,
        seq=100,
        stamp=1.0,
        episode=0,
        link=LinkId(upstream, sender),
        age=0.0,
        plan=None,
        counts=LinkCounts(),
        solve=0.0,
        missed=0,
        gap=0.0,
        rejected=0,
        pid=1,
    )
    return replace(whole, **changes)


def state(
    robots: int = 3, *, stamp: float = 1.0, episode: int = 0, events: tuple[Event, ...] = (), **changes: object
) -> State:
    fields: dict[str, object] = {
        "sender": 0,
        "seq": 1,
        "stamp": stamp,
        "episode": episode,
        "revision": 0,
        "scenario": "triangle-circle",
        "controller": "nash",
        "mode": "lockstep",
        "status": "running",
        "waiting_for": [],
        "dismissed": [],
        "speed": 1.0,
        "pace": 1.0,
        "overruns": 0,
        "contacts": 0,
        "gap": 0.03,
        "rejected": 0,
        "poses": np.zeros((robots, 3)),
        "slots": np.zeros((robots, 3)),
        "centre": np.zeros(3),
        "distance_errors": np.full(robots, 0.001),
        "angle_errors": np.zeros(robots),
        "tracking_error": 0.0,
        "live": list(range(1, robots + 1)),
        "stopped": [],
        "faults": {},
        "events": list(events),
        "compare": "",
    }
    return State(**{**fields, **changes})  # type: ignore[arg-type]
