"""`echelon status`: the state of a live run."""

import argparse
import dataclasses
import json

import numpy as np
from rich.console import Console
from rich.table import Table

from cli.live.talk import newest_state
from cli.options import add_run, session
from network.messages import State
from runtime.run_registry import live as live_runs

MILLI = 1e3


def arguments(parser: argparse.ArgumentParser) -> None:
    """What the command accepts."""
    add_run(parser)
    parser.add_argument("--json", action="store_true", help="print one JSON object")


def run(options: argparse.Namespace) -> None:
    """Print the world's newest state."""
    with session(options) as live:
        state = newest_state(live)
        name = live.run
    page = next((run.page for run in live_runs() if run.name == name), "")
    if options.json:
        print(json.dumps({"run": name, "page": page, **_plain(state)}, default=dataclasses.asdict))
    else:
        _print(name, page, state)


def _plain(state: State) -> dict[str, object]:
    fields = {field.name: getattr(state, field.name) for field in dataclasses.fields(state)}
    fields["faults"] = {str(link): fault.plain() for link, fault in state.faults.items()}
    return {key: value.tolist() if isinstance(value, np.ndarray) else value for key, value in fields.items()}


def _print(name: str, page: str, state: State) -> None:
    console = Console()
    waiting = f", waiting for agents {', '.join(map(str, state.waiting_for))}" if state.waiting_for else ""
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
