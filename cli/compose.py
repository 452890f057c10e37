"""`echelon compose`: a compose file for a scenario."""

import argparse

from cli.options import add_scenario, load
from formation.errors import ScenarioError, unknown
from formation.scenario.files import shipped
from runtime.compose import compose_file


def arguments(parser: argparse.ArgumentParser) -> None:
    """What the command accepts."""
    add_scenario(parser)
    parser.add_argument("--realtime", action="store_true", help="step by the wall clock, and wait for no agent")
    parser.add_argument("--record", action="store_true", help="record the run, in a volume")


def run(options: argparse.Namespace) -> None:
    """Print it."""
    if options.scenario not in shipped():
        raise ScenarioError(unknown("scenario in the image", options.scenario, shipped()))
    scenario, overrides = load(options)
    print(compose_file(options.scenario, scenario, overrides, record=options.record, realtime=options.realtime), end="")
