"""`echelon up`: a live run on this machine, until Ctrl-C."""

import argparse
import errno
import re
import socket
from collections.abc import Iterable, Iterator
from itertools import groupby
from pathlib import Path

from setproctitle import setproctitle

from cli.hosting import add_hosting, hosting, tell_how_to_join
from cli.light_options import DEFAULT_PORT, LOOPBACK
from cli.options import add_record, add_scenario, add_together, load, record_file, tell, together, warn
from dashboard.serving import access
from formation.errors import EchelonError
from formation.scenario.scenario import Scenario
from network.access.robot_numbers import spelled
from network.control import checked_speed
from network.values import Event
from ros.readiness import check, reachable
from ros.spec import FORM, RobotSpec, parse_all, parse_router
from ros.types import distribution
from runtime.launcher import LiveRun
from runtime.run_registry import free_name

DEFAULT_SCENARIO = "follow-the-leader"
"""Where a cut link is seen at once: without messages nobody but robot 1 knows where to go."""
HERE = re.compile(r"agent (\d+) is here")
"""The event of an agent that has come."""


def arguments(parser: argparse.ArgumentParser) -> None:
    """What the command accepts."""
    add_scenario(parser, DEFAULT_SCENARIO)
    parser.add_argument("--run", metavar="NAME", help="name of the run (default: the scenario's)")
    parser.add_argument("--port", type=int, default=DEFAULT_PORT, help=f"of the page (default: {DEFAULT_PORT}; 0: any)")
    parser.add_argument(
        "--host", default=LOOPBACK, help="to serve the page on (default: loopback); others demand a token"
    )
    parser.add_argument(
        "--token",
        help=f"for --host, 16 characters or more (default: ${access.TOKEN}, else a new one, which is printed)",
    )
    parser.add_argument("--no-dashboard", action="store_true", help="start no dashboard")
    parser.add_argument("--realtime", action="store_true", help="step by the wall clock, do not wait for slow agents")
    parser.add_argument("--speed", type=float, default=1.0, help="simulated seconds per second (default: 1)")
    parser.add_argument("--paused", action="store_true", help="wait for Start")
    add_hosting(parser)
    parser.add_argument(
        "--robot",
        action="append",
        default=[],
        metavar=FORM,
        help="robot N is a real one of ROS 2, a client of whose router drives it; implies --realtime",
    )
    parser.add_argument(
        "--ros",
        metavar="ENDPOINT[,domain=0]",
        help="show the robots to the ROS 2 at this router",
    )
    add_together(parser)
    add_record(parser)


def run(options: argparse.Namespace) -> int:
    """Run until Ctrl-C or a stop request."""
    scenario, _ = load(options)
    checked_speed(options.speed, "--speed")
    wished = together(options)
    hosts = hosting(options)
    dashboard = None if options.no_dashboard else (options.host, _port(options.host, options.port))
    token = access.given_token(options.token)
    if token is None and options.host not in access.LOOPBACK:
        token = access.new_token()
    if options.token is not None:
        setproctitle("echelon up")  # everybody on this machine can read command lines
    warn(scenario)
    robots = _real_robots(options, scenario)
    ros = None if options.ros is None else reachable(*parse_router(options.ros))
    name = options.run or free_name(scenario.name)
    record = record_file(options, scenario.name)
    with LiveRun(
        name,
        scenario,
        tell=tell,
        dashboard=dashboard,
        token=token,
        realtime=options.realtime or bool(robots),
        ros=ros,
        robots=tuple((number, str(spec)) for number, spec in robots.items()),
        speed=options.speed,
        paused=options.paused,
        together=wished,
        endless=True,
        ghost=True,
        record=None if record is None else str(record),
        detail=options.detail,
        scenarios=str(Path.cwd()),
        **hosts,
    ) as live:
        tell(f"running {scenario.name} with {scenario.size} robots as run {name}; Ctrl-C ends it")
        if dashboard is not None and options.host not in access.LOOPBACK:
            tell(
                "the page is not encrypted, nor is its token: in a network you do not trust leave out --host and use "
                f"ssh -L {dashboard[1]}:127.0.0.1:{dashboard[1]} HOST, or a proxy with TLS (docs/hosts.md)"
            )
        tell_how_to_join(live, hosts)
        if record is not None:
            tell(f"recording in {record}")
        shown = 0
        try:
            while live.watch():
                events = live.state.events if live.state else []
                if events and events[-1].number < shown:  # a world that was started again counts anew
                    shown = 0
                for line in lines(event for event in events if event.number > shown):
                    tell(line)
                shown = max([shown, *(event.number for event in events)])
        except KeyboardInterrupt:
            tell("stopping")
    if live.record_fault:
        tell(f"{record} is no whole record: {live.record_fault}")
    return 0


def lines(events: Iterable[Event]) -> Iterator[str]:
    """Events as they are told, oldest first; agents that came one right after the other are one line."""
    for (stamp, here), group in groupby(events, lambda event: (event.stamp, HERE.fullmatch(event.text) is not None)):
        texts = [event.text for event in group]
        if here and len(texts) > 1:
            robots = (int(number) for text in texts for number in HERE.findall(text))
            texts = [f"agents {spelled(robots)} are here"]
        yield from (f"t = {stamp:.2f} s: {text}" for text in texts)


def _real_robots(options: argparse.Namespace, scenario: Scenario) -> dict[int, RobotSpec]:
    """The real robots by number, each looked at. Raises EchelonError: one cannot take part."""
    robots = parse_all(options.robot, scenario.size)
    if robots and options.speed != 1.0:
        raise EchelonError(f"--speed: expected 1 with --robot, for a real robot has one; got {options.speed:g}")
    if robots:
        for number, (command, pose) in check(scenario, robots).items():
            tell(
                f"robot {number} is real: {command.topic} ({command.type}, {distribution(command.hash)}), "
                f"pose from {pose.topic} ({pose.type})"
            )
    return robots


def _port(host: str, port: int) -> int:
    """The port if it is free, or any free one for 0."""
    with socket.socket(socket.AF_INET6 if ":" in host else socket.AF_INET) as probe:
        probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            probe.bind((host, port))
        except (OSError, OverflowError) as error:
            if isinstance(error, socket.gaierror) or getattr(error, "errno", 0) == errno.EADDRNOTAVAIL:
                raise EchelonError(f"--host: expected an address of this machine; got {host!r}") from None
            raise EchelonError(
                f"--port: expected a free port of {host}; got {port}, which is taken or not allowed "
                "(0 takes any free one)"
            ) from None
        return int(probe.getsockname()[1])
