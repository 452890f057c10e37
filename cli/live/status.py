"""`echelon status`: the state of a live run."""

import argparse
import contextlib
import dataclasses
import json

import numpy as np
from rich.console import Console
from rich.table import Table

from cli.live.talk import newest_state
from cli.options import add_run, session
from formation.errors import WireError
from network import topics
from network.access.robot_numbers import spelled
from network.bus import Bus, Sample
from network.codec import decode
from network.messages import State, Status
from runtime.run_registry import live as live_runs

MILLI, MICRO = 1e3, 1e6
STATUS_SECONDS = 0.5
"""Longest wait for the statuses of agents; they come ten times a second [s]."""


def arguments(parser: argparse.ArgumentParser) -> None:
    """What the command accepts."""
    add_run(parser)
    parser.add_argument("--json", action="store_true", help="print one JSON object")


def run(options: argparse.Namespace) -> None:
    """Print the world's newest state."""
    with session(options) as live:
        live.subscribe(topics.status(live.run, "*"))
        state = newest_state(live)
        links = _links(live, state)
        name = live.run
    page = next((run.page for run in live_runs() if run.name == name), "")
    if options.json:
        found = {"run": name, "page": page, **_plain(state), "links": [_row(status) for status in links]}
        print(json.dumps(found, default=dataclasses.asdict))
    else:
        _print(name, page, state)
        _print_links(links)


def _links(live: Bus, state: State) -> list[Status]:
    """The newest status of every live agent, by robot; of those that say something within half a second."""
    found: dict[int, Status] = {}
    for item in live.incoming(STATUS_SECONDS):
        if isinstance(item, Sample) and topics.topic_of(item.key) is topics.STATUS:
            with contextlib.suppress(WireError):  # not a valid message
                status = decode(Status, item.payload)
                found[status.sender] = status
        if set(state.live) <= found.keys():
            break
    return [found[robot] for robot in sorted(found)]


def _row(status: Status) -> dict[str, object]:
    counts = status.counts
    return {
        "link": str(status.link),
        "age_s": status.age,
        "sent": counts.sent,
        "lost": counts.lost,
        "late": counts.late,
        "missed": status.missed,
        "solve_s": status.solve,
    }


def _print_links(links: list[Status]) -> None:
    table = Table("link", "age ms", "sent", "lost", "late", "ticks missed", "solve us")
    for status in links:
        counts = status.counts
        share = f" ({counts.lost / counts.sent:.0%})" if counts.lost else ""
        table.add_row(
            str(status.link),
            f"{status.age * MILLI:.0f}",
            str(counts.sent),
            f"{counts.lost}{share}",
            str(counts.late),
            str(status.missed),
            f"{status.solve * MICRO:.0f}",
        )
    if links:
        Console().print(table)


def _plain(state: State) -> dict[str, object]:
    fields = {field.name: getattr(state, field.name) for field in dataclasses.fields(state)}
    fields["faults"] = {str(link): fault.plain() for link, fault in state.faults.items()}
    return {key: value.tolist() if isinstance(value, np.ndarray) else value for key, value in fields.items()}


def _print(name: str, page: str, state: State) -> None:
    console = Console()
    waiting = f", waiting for agents {spelled(state.waiting_for)}" if state.waiting_for else ""
    console.print(
        f"{name}: {state.status} at t = {state.stamp:.2f} s, {state.scenario} with {state.controller}, "
        f"{state.mode} at x{state.pace:.2g}{waiting}",
        markup=False,
    )
    if page:
        console.print(f"page: {page}")
    table = Table("robot", "agent", "distance error mm", "angle error rad")
    for i, (distance, angle) in enumerate(zip(state.distance_errors, state.angle_errors, strict=True), start=1):
        alive = "alive" if i in state.live else "lost"
        table.add_row(
            str(i), alive + (", stopped" if i in state.stopped else ""), f"{distance * MILLI:.3f}", f"{angle:.4f}"
        )
    console.print(table)
    console.print(f"centre to path {state.tracking_error * MILLI:.3f} mm")
    driving = state.driving
    if driving.goal is not None:
        console.print(f"drives to ({driving.goal[0]:.3f}, {driving.goal[1]:.3f}) m")
    elif driving.orders:
        console.print(f"driven at {driving.v:.3g} m/s, {driving.omega:.3g} rad/s")
    if state.recording is not None:
        console.print(f"recorded in {state.recording.file}: {state.recording.bytes / 1e6:.1f} MB", markup=False)
    for link, fault in sorted(state.faults.items()):
        console.print(f"link {link}: {fault.words()}", markup=False)
    for event in state.events[-5:]:
        console.print(f"t = {event.stamp:.2f} s: {event.text}", markup=False)
