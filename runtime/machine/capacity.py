"""How many agents this machine bears in real time: measured in about a second, not guessed.

An agent's tick is its own work and its messages: a tick comes in, a plan goes to a neighbour, a command to the world.
Both are measured as processor time, with everything that router and receivers spend.
"""

import os
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

from formation.errors import EchelonError
from formation.scenario.files import load
from network import topics
from network.codec import decode, encode
from network.messages import Command, Plan, Tick
from network.zenoh_bus import Router, ZenohBus

ROBOTS = 8
"""Of the simulation that is measured."""
TICKS, ROUND_TRIPS = 40, 200
"""That are measured; ticks after as many others."""
DELIVERIES = 3
"""Of an agent with a process of its own, in a tick; in a process of several, one: its command."""
SHARE = 0.6
"""Of the machine that agents may take: the rest is the world's, the router's and the page's."""
PATIENCE = 2.0
"""Longest wait for a message [s]."""
PRIVATE = 45 << 20
"""Memory of an agent's process that no other shares [bytes]."""


@dataclass(frozen=True, slots=True)
class Capacity:
    """What this machine bears at 100 ticks a second."""

    cores: int
    alone: int
    """Agents with a process each."""
    together: int
    """Agents in processes of several, one process a core."""


def measured() -> Capacity:
    """The capacity of this machine as it is now. Raises EchelonError: nothing can be measured here."""
    work, way = _work(), _way()
    budget = SHARE * cores() * 0.01
    room = max(2, _available() // PRIVATE)
    return Capacity(cores(), min(room, int(budget / (work + DELIVERIES * way))), int(budget / (work + way)))


def cores() -> int:
    """Cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def _work() -> float:
    """Of one agent in a tick, with what it encodes and decodes, and what the world does for it [s]."""
    from runtime.inprocess import Simulation  # noqa: PLC0415  half a second, for numba; who starts a run has no use

    simulation = Simulation(load("ring-16", {"formation": {"robots": ROBOTS}}))
    for _ in range(TICKS):
        answers = simulation.step()
    tick, answer = simulation.world.tick(), answers[1]
    began = time.process_time()
    for _ in range(TICKS):
        simulation.step()
        for _ in range(ROBOTS):
            if answer.plan is not None:
                decode(Plan, encode(answer.plan))
            decode(Command, encode(answer.command))
        decode(Tick, encode(tick))
    return (time.process_time() - began) / TICKS / ROBOTS


def _way() -> float:
    """Of one message from one process to another, over the router [s]."""
    run, there, back = "capacity", topics.command("capacity", 1), topics.command("capacity", 2)
    message = Command(1, 0, 0.0, 0, 0.1, 0.1, age=0.0, planned=True, solve=1e-4)
    with tempfile.TemporaryDirectory(prefix="ech") as folder:
        endpoint = f"unixsock-stream/{folder}/r"
        router = Router([endpoint])
        try:
            with ZenohBus(endpoint, run) as one, ZenohBus(endpoint, run) as other:
                one.subscribe(back)
                other.subscribe(there)
                one.announce(there, reliable=True)
                other.announce(back, reliable=True)
                for sender, key, receiver in ((one, there, other), (other, back, one)):
                    _meet(sender, key, receiver, message)
                began = time.process_time()
                for _ in range(ROUND_TRIPS):
                    one.publish(there, message)
                    other.arrivals(PATIENCE)
                    other.publish(back, message)
                    one.arrivals(PATIENCE)
                return (time.process_time() - began) / (2 * ROUND_TRIPS)
        finally:
            router.close()


def _meet(sender: ZenohBus, key: str, receiver: ZenohBus, message: Command) -> None:
    """Send until something arrives: a subscription takes a moment."""
    until = time.monotonic() + PATIENCE
    while time.monotonic() < until:
        sender.publish(key, message)
        if receiver.arrivals(0.02):
            return
    raise EchelonError("messages do not arrive on this machine")


def _available() -> int:
    """Memory that new processes can have [bytes]."""
    for line in Path("/proc/meminfo").read_text(encoding="utf-8").splitlines():
        if line.startswith("MemAvailable:"):
            return int(line.split()[1]) << 10
    return 1 << 40
