"""Agents of all robots that the run's scenario has; if several of these processes run, each takes its share."""

import argparse
import sys
from functools import partial

from agents.controllers.own import load_controller
from formation.errors import EchelonError
from network.arguments import add_connection, connect, host_number
from runtime.endings import Endings
from runtime.keeping.process import Keeper
from runtime.precompile import ensure_compiled
from runtime.process_list import RunPlan, agents
from runtime.user_code import CodeArguments


def main(arguments: list[str] | None = None) -> int:
    """Run agents until the process is asked to end."""
    parser = argparse.ArgumentParser(prog="python -m runtime.keeping", description=__doc__)
    add_connection(parser)
    parser.add_argument("--controller", action="append", default=[], metavar="FILE.py:CLASS", help="of your own")
    parser.add_argument("--id", type=int, default=host_number(), help="among these processes (default: by the host)")
    options = parser.parse_args(arguments)
    endings = Endings()
    endings.begin()
    try:
        for spec in options.controller:
            load_controller(spec)
        ensure_compiled(_tell)
        keys = None if options.keys is None else str(options.keys)
        code = CodeArguments(controllers=tuple(options.controller))
        plan = RunPlan(options.run, "", options.connect, (), keys=keys, insecure=options.insecure, code=code)
        with (
            connect(options, "keeper") as bus,
            Keeper(bus, options.id, partial(agents, plan), _tell) as kept,
        ):
            try:
                while True:
                    kept.watch()
            finally:
                endings.ignore()
    except KeyboardInterrupt:
        return 0
    except EchelonError as error:
        print(f"agents: {error}", file=sys.stderr)
        return 2


def _tell(line: str) -> None:
    print(f"agents: {line}\n", end="", file=sys.stderr, flush=True)  # at once: containers' logs split at writes


if __name__ == "__main__":
    sys.exit(main())
