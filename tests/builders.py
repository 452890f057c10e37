"""Messages for tests: whole ones, of which a test names only what it is about."""

import numpy as np

from formation.links import LinkId
from network.messages import Event, LinkCounts, Plan, State, Status


def plan(sender: int, seq: int, episode: int = 0) -> Plan:
    return Plan(sender, seq, 0.01 * seq, episode, np.array([1.0, 2.0, 0.5]), 0.1, np.full((20, 2), 0.1))


def status(
    sender: int,
    upstream: int,
    *,
    plan: Plan | None = None,
    held: Plan | None = None,
    age: float = 0.0,
    stamp: float = 1.0,
) -> Status:
    return Status(
        sender=sender,
        seq=100,
        stamp=stamp,
        episode=0,
        link=LinkId(upstream, sender),
        age=age,
        plan=plan,
        held=held,
        counts=LinkCounts(),
        solve=0.0,
        missed=0,
        gap=0.0,
        rejected=0,
        pid=1,
    )


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
