"""`echelon join`: run agents of a run on another host, until Ctrl-C or until it is over."""

import argparse

from cli.light_options import add_controllers
from cli.options import controllers, tell
from formation.errors import EchelonError
from network.access.keys import address, host_and_port
from network.access.robot_numbers import parsed, spelled
from network.arguments import INSECURE
from runtime.hosts.enrolment import enrol
from runtime.hosts.joined import JoinedRun
from runtime.hosts.open_run import found_at


def arguments(parser: argparse.ArgumentParser) -> None:
    """What the command accepts."""
    parser.add_argument(
        "host", metavar="HOST[:PORT]", help="where the run listens, as `echelon up --listen` printed it"
    )
    parser.add_argument("code", nargs="?", help="as it was printed there")
    parser.add_argument("--agents", metavar="1-8", help="robots to run agents of (default: all that have none)")
    add_controllers(parser)
    parser.add_argument("--transport", choices=["tcp", "udp"], default="tcp", help="with --insecure, as the run has it")
    parser.add_argument("--insecure", action="store_true", help=f"for a run that listens so: {INSECURE}")


def run(options: argparse.Namespace) -> int:
    """Run agents until Ctrl-C, or until the run is over."""
    controllers(options)
    host, port = host_and_port(options.host)
    wished = None if options.agents is None else parsed(options.agents)
    if options.insecure:
        admission, endpoint = None, f"{options.transport}/{address(host, port)}"
        name, robots = found_at(endpoint, wished)
    elif options.code is None:
        raise EchelonError(
            f"expected a code (on {host}: echelon invite agents), or --insecure for a run that listens so"
        )
    else:
        admission = enrol(host, port, options.code, ("agents",), None if wished is None else sorted(wished))
        name, endpoint = admission.run, admission.endpoint
        robots = frozenset(int(name.removeprefix("agent-")) for name in admission.certificates)
    with JoinedRun(name, endpoint, robots, admission=admission, tell=tell) as joined:
        tell(f"running agents {spelled(robots)} of run {name} on {host}; Ctrl-C leaves it")
        try:
            while joined.watch():
                pass
            tell(f"run {name} is over")
        except KeyboardInterrupt:
            tell("leaving")
    return 0
