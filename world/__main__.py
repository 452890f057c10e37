"""The world process of a run."""

import argparse
import logging
import os
import secrets
import sys
from pathlib import Path

from formation.errors import EchelonError
from formation.scenario.files import load
from formation.scenario.overrides import from_json
from formation.scenario.registry import check_live, register_unloaded
from formation.scenario.user_code import from_text
from network.arguments import add_connection, connect
from network.lifetime import TERMINATED, Lifetime
from network.values import Event, Mode
from world.bodies.own import load_bodies
from world.parts import Parts
from world.process import run
from world.real_robots import MixedWorld, RealRobots
from world.resume.saver import Saver, saved
from world.resume.snapshot import SnapshotError
from world.world import World

IN_CONTAINER = "ECHELON_IN_CONTAINER"
"""Environment variable: there is no `up` that would print the run's events."""


def main(arguments: list[str] | None = None) -> int:
    """Step the world until the process is asked to end."""
    parser = argparse.ArgumentParser(prog="python -m world", description=__doc__)
    add_connection(parser)
    parser.add_argument("--scenario", required=True, help="name or TOML file")
    parser.add_argument("--overrides", default="{}", metavar="JSON", help="what differs from the scenario's file")
    parser.add_argument("--realtime", action="store_true", help="step by the wall clock, not in lockstep")
    parser.add_argument("--speed", type=float, default=1.0, help="simulated seconds per second; 0: as fast as possible")
    parser.add_argument("--endless", action="store_true", help="continue closed paths past the scenario's duration")
    parser.add_argument("--paused", action="store_true", help="wait for a start command")
    parser.add_argument("--bodies", action="append", default=[], metavar="FILE.py:CLASS", help="of your own")
    parser.add_argument("--folder", metavar="FOLDER", help="where the run is saved, and goes on from")
    parser.add_argument(
        "--controllers", default="[]", metavar="JSON", help="what is known of controllers of users' own"
    )
    parser.add_argument("--real", type=int, action="append", default=[], metavar="N", help="a robot that is real")
    options = parser.parse_args(arguments)
    logging.basicConfig(format="%(name)s world: %(message)s", stream=sys.stderr)
    try:
        for spec in options.bodies:
            load_bodies(spec)
        register_unloaded(from_text(options.controllers))
        show = _print if os.environ.get(IN_CONTAINER) else None
        folder = Path(options.folder) if options.folder else None
        parts = (_saved(folder) if folder else None) or _begun(options)
        with connect(options, "world") as bus:
            robots = parts.world.real if isinstance(parts.world, MixedWorld) else None
            stopped = run(bus, parts, Lifetime(bus.wake), Saver(folder) if folder else None, robots, show)
    except EchelonError as error:
        print(f"world: {error}", file=sys.stderr)
        return 2
    return 0 if stopped else TERMINATED


def _print(event: Event) -> None:
    print(
        f"t = {event.stamp:.2f} s: {event.text}\n", end="", file=sys.stderr, flush=True
    )  # at once: logs split at writes


def _saved(folder: Path) -> Parts | None:
    """The run that another process has saved, if there is one that can be read."""
    try:
        return saved(folder)
    except SnapshotError as error:
        print(f"world: cannot go on, the run begins anew: {error}", file=sys.stderr)
        return None


def _begun(options: argparse.Namespace) -> Parts:
    """A run that begins. Raises ScenarioError."""
    scenario = load(options.scenario, from_json(options.overrides))
    check_live(scenario.controller.name)
    mode: Mode = "realtime" if options.realtime else "lockstep"
    episode = secrets.randbits(48)  # a world that was started again must not be mistaken for the one before
    if options.real:
        robots = RealRobots(options.run, options.real)
        world: World = MixedWorld(scenario, robots, episode=episode, endless=options.endless)
    else:
        world = World(scenario, episode=episode, endless=options.endless, mode=mode)
    return Parts.of(world, speed=options.speed, start=not options.paused)


if __name__ == "__main__":
    sys.exit(main())
