"""`echelon control`: time and agents of a live run."""

import argparse
from collections.abc import Iterable

from cli.live.talk import ask
from cli.options import add_run, session
from dashboard.scenario_list import use_table
from formation.disturbances import PUSHES
from formation.errors import EchelonError, unknown
from formation.scenario.files import is_file, load, shipped
from formation.shapes import SHAPES
from network import control
from network.control import Operation
from network.requests import Request

_ACTIONS = {
    "start": "start, or continue",
    "pause": "stop simulated time",
    "step": "pause, then run one tick or several",
    "reset": "start a new episode",
    "speed": "simulated seconds per second; 0: as fast as possible",
    "scenario": "switch to another scenario",
    "controller": "start again with another controller",
    "kill": "kill a robot's agent, and keep it down",
    "restart": "start a robot's agent again",
    "leave": "take a robot out of the ring, which closes over it; it stands",
    "join": "take it into the ring again",
    "compare": "run a ghost beside it: another controller with the same faults; off: end it",
    "drive": "order a driven formation a speed V [m/s] and a turn rate OMEGA [rad/s]",
    "goto": "drive a driven formation's centre to X Y [m], and stop there",
    "push": f"disturb a robot's body: {', '.join(f'{kind} ({push.help})' for kind, push in PUSHES.items())}",
    "move": "take a robot and carry it aside by DX DY [m], within half a second",
    "release": "end what disturbs a robot, or all",
    "shape": "change the shape of the formation, its spacing, or both",
    "record": "record the run in a new file, or close it",
    "stop": "end the run and its processes",
}
_PAIRS = {"drive": ("V", "OMEGA"), "goto": ("X", "Y")}
"""Actions with two numbers."""
_ASIDE = "DX", "DY"
_INTERVENTIONS = ("push", "move", "release", "shape")
"""Actions on the robots."""


def arguments(parser: argparse.ArgumentParser) -> None:
    """What the command accepts."""
    actions = parser.add_subparsers(dest="action", metavar="|".join(_ACTIONS), required=True)
    for name, text in _ACTIONS.items():
        action = actions.add_parser(name, help=text)
        if name == "step":
            action.add_argument("value", nargs="?", default="1", metavar="TICKS")
        elif name in ("kill", "restart", "leave", "join"):
            action.add_argument("value", metavar="ROBOT", help="its number, from 1")
        elif name in ("speed", "scenario", "controller", "compare"):
            action.add_argument("value", metavar="CONTROLLER|off" if name == "compare" else name.upper())
        elif name == "record":
            action.add_argument("value", choices=["on", "off"])
        elif name in _PAIRS:
            _add_numbers(action, _PAIRS[name])
        elif name == "push":
            action.add_argument("robot", metavar="ROBOT", help="its number, from 1")
            action.add_argument("value", metavar="|".join(PUSHES))
            action.add_argument("--for", dest="seconds", metavar="TIME", help="such as 10s; default: until `release`")
        elif name == "move":
            action.add_argument("robot", metavar="ROBOT", help="its number, from 1")
            _add_numbers(action, _ASIDE)
        elif name == "release":
            action.add_argument("robot", metavar="ROBOT|all", nargs="?", default="all")
        elif name == "shape":
            action.add_argument("value", metavar="SHAPE", nargs="?", help=f"{', '.join(SHAPES)}; default: it stays")
            action.add_argument("--spacing", metavar="M", help="between neighbours; default: it stays")
            action.add_argument("--over", metavar="TIME", help="how long the change takes; default: derived")
        if name == "drive":
            action.add_argument(
                "--for", dest="seconds", metavar="S", help="then it stops; default: until the next order"
            )
        add_run(action)


def _add_numbers(action: argparse.ArgumentParser, names: Iterable[str]) -> None:
    """An argument each: argparse cannot name one of two values when it is missing."""
    for name in names:
        action.add_argument(name.lower(), metavar=name)


def run(options: argparse.Namespace) -> None:
    """Send the operation to the world."""
    if options.action in _PAIRS:
        operation = _pair(options)
    elif options.action in _INTERVENTIONS:
        operation = _intervention(options)
    else:
        operation = _operation(options.action, getattr(options, "value", ""))
    with session(options, orders=True) as live:
        done = ask(live, operation).value
    if isinstance(operation, control.Drive) and (done.get("v"), done.get("omega")) != (operation.v, operation.omega):
        print(f"drives at {done.get('v'):.3g} m/s and {done.get('omega'):.3g} rad/s, which is as fast as it can")


def _pair(options: argparse.Namespace) -> Operation:
    action, seconds = options.action, getattr(options, "seconds", None)
    numbers = _numbers(options, _PAIRS[action])
    return control.operation(Request(action, {**numbers, **({} if seconds is None else {"seconds": seconds})}))


def _numbers(options: argparse.Namespace, names: Iterable[str]) -> dict[str, float]:
    """Of `_add_numbers`. Raises EchelonError."""
    return {name.lower(): _number(options.action, getattr(options, name.lower()), float) for name in names}


def _intervention(options: argparse.Namespace) -> Operation:
    """What is done to the robots."""
    action, wanted = options.action, dict[str, object]()
    if action in ("push", "move") or (action == "release" and options.robot != "all"):
        wanted["robot"] = _number(action, options.robot, int, prefix="robot-")
    match action:
        case "push":
            wanted |= {"kind": options.value, "seconds": options.seconds}
        case "move":
            wanted |= _numbers(options, _ASIDE)
        case "shape":
            spacing = None if options.spacing is None else _number("--spacing", options.spacing, float)
            wanted |= {"shape": options.value, "spacing": spacing, "over": options.over}
    return control.operation(Request(action, wanted))


def _operation(action: str, value: str) -> Operation:
    match action:
        case "step":
            return control.Step.model_validate({"ticks": _number(action, value, int)})
        case "speed":
            return control.Speed(speed=control.checked_speed(_number(action, value, float, prefix="x")))
        case "scenario":
            return _scenario(value)
        case "controller":
            return control.UseController(controller=value)
        case "kill" | "restart" | "leave" | "join":
            return control.operation(Request(action, {"robot": _number(action, value, int, prefix="agent-")}))
        case "record":
            return control.Record(on=value == "on")
        case "compare":
            return control.operation(Request("compare", {"controller": value}))
        case _:
            return control.operation(Request(action))


def _scenario(name: str) -> Operation:
    """A shipped scenario by its name; a file as the table that it holds, for the world reads none."""
    if not is_file(name):
        if name not in shipped():
            raise EchelonError(unknown("scenario", name, [*shipped(), "FILE.toml"]))
        return control.UseScenario(scenario=name)
    return use_table(load(name))


def _number(action: str, value: str, kind: type[int] | type[float], *, prefix: str = "") -> float:
    """A number, which a user may write behind a prefix: x2, agent-3."""
    try:
        number = kind(value.removeprefix(prefix))
    except ValueError:
        raise EchelonError(f"{action}: expected a number; got {value!r}") from None
    if action == "step" and not 1 <= number <= 100_000:
        raise EchelonError(f"step: expected 1 to 100000 ticks; got {value}")
    return number
