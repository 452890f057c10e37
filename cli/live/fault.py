"""`echelon fault`: set and clear the faults of a live run's links."""

import argparse
import json
from collections.abc import Mapping
from typing import Any

from cli.live.talk import ask, newest_state
from cli.options import add_run, session
from formation.errors import FaultError
from formation.faults import PERFECT, PRESETS, SHOWN, Fault, with_changes
from formation.link_ids import LinkId
from network.control import operation
from network.requests import Request

_OPERATIONS = {"set": "fault", "preset": "preset", "clear": "clear"}
_FLAGS = ("cut", "keep_order")
_KEYS = tuple(key for key in Fault.model_fields if key not in _FLAGS)


def arguments(parser: argparse.ArgumentParser) -> None:
    """What the command accepts."""
    actions = parser.add_subparsers(dest="action", metavar="set|preset|clear|show", required=True)
    change = actions.add_parser("set", help="change what a link does; keys not named stay as they are")
    for key in _KEYS:
        change.add_argument(f"--{key}", metavar=SHOWN[key].argument, help=_help(key))
    change.add_argument("--cut", action="store_true", default=None, help=_help("cut"))
    change.add_argument("--mend", action="store_false", dest="cut", help="messages pass again")
    change.add_argument("--keep-order", action="store_true", default=None, help=_help("keep_order"))
    preset = actions.add_parser("preset", help="give a link a named fault")
    preset.add_argument("name", help=", ".join(PRESETS))
    clear = actions.add_parser("clear", help="remove what was set, and end the scheduled faults that are active now")
    show = actions.add_parser("show", help="every link that is not healthy")
    show.add_argument("--json", action="store_true", help="print one JSON object")
    for action in (change, preset, clear):
        action.add_argument("--link", default="all", help='such as "1->2" or "world->1"; default: all')
    for action in (change, preset):
        action.add_argument("--for", dest="seconds", metavar="TIME", help="until then, such as 10s (simulated time)")
    for action in (change, preset, clear, show):
        add_run(action)


def run(options: argparse.Namespace) -> None:
    """Send the operation, or show the faults in force."""
    changes: dict[str, Any] = {}
    if options.action == "set":
        given = {key: getattr(options, key) for key in (*_KEYS, *_FLAGS)}
        wished = {key: value for key, value in given.items() if value is not None}
        if not wished:
            raise FaultError(f"expected at least one of {', '.join('--' + key for key in (*_KEYS, 'cut', 'mend'))}")
        checked = with_changes(PERFECT, wished)
        changes = {key: getattr(checked, key) for key in wished}
    wanted: dict[str, Any] = {}
    match options.action:
        case "set":
            wanted = {"link": options.link, "changes": changes, "seconds": options.seconds}
        case "preset":
            wanted = {"link": options.link, "preset": options.name, "seconds": options.seconds}
        case "clear":
            wanted = {"link": options.link}
    asked = operation(Request(_OPERATIONS[options.action], wanted)) if wanted else None
    with session(options, orders=asked is not None) as live:
        if asked is not None:
            ask(live, asked)
        else:
            _show(newest_state(live).faults, as_json=options.json)


def _help(key: str) -> str:
    """The key's own description, as argparse wants it."""
    return (Fault.model_fields[key].description or "").replace("%", "%%")


def _show(faults: Mapping[LinkId, Fault], *, as_json: bool) -> None:
    if as_json:
        print(json.dumps({str(link): fault.plain() for link, fault in faults.items()}))
    elif not faults:
        print("every link is healthy")
    for link, fault in () if as_json else sorted(faults.items()):
        print(f"{link}: {fault.words()}")
