"""Every key of the page: what binds keys and the help that lists them (overlay/help.py) both take them from here.

Keys of viser's own, which this program does not bind, are in OF_VISER.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import viser

HELP = "?"
"""Opens and closes the help, as KeyboardEvent.key has it; Escape closes it too."""


class Shortcut(NamedTuple):
    """The key of a command."""

    key: str
    """As viser names it."""
    meaning: str
    """More than its name, or empty."""


class Drive(NamedTuple):
    """A key that drives."""

    shown: str
    meaning: str
    signs: tuple[int, int]
    """Of v and omega."""


class Handle(NamedTuple):
    """A key of the time line's handle."""

    shown: str
    meaning: str
    words: str
    """What the playhead is told; "begin" is the first moment that is kept."""


class Cell(NamedTuple):
    """A key of a table's cell."""

    shown: str
    meaning: str
    step: int
    """To which cell it goes from this one; 0 presses it."""


COMMANDS = {
    "Start or pause": Shortcut("P", ""),
    "Step": Shortcut("S", "a few ticks"),
    "Reset": Shortcut("R", "begin a new episode"),
    "Clear all faults": Shortcut("C", ""),
    "View: Fit": Shortcut("F", "all robots and the path"),
    "View: 3D": Shortcut("D", "tilt, and back"),
    "View: Follow": Shortcut("G", "keep the robots in the middle"),
    "Time line: the run as it is": Shortcut("L", ""),
    "Time line: next event": Shortcut("N", ""),
    "Time line: event before": Shortcut("B", ""),
}
"""By the command's name."""
DRIVING = {
    "KeyW": Drive("W", "ahead", (1, 0)),
    "ArrowUp": Drive("↑", "ahead", (1, 0)),
    "KeyS": Drive("S", "back", (-1, 0)),
    "ArrowDown": Drive("↓", "back", (-1, 0)),
    "KeyA": Drive("A", "turn left", (0, 1)),
    "ArrowLeft": Drive("←", "turn left", (0, 1)),
    "KeyD": Drive("D", "turn right", (0, -1)),
    "ArrowRight": Drive("→", "turn right", (0, -1)),
}
"""By KeyboardEvent.code: held on the page that has the wheel."""
HANDLE = {
    "ArrowLeft": Handle("←", "a second back (with Shift a tenth)", "step,-1"),
    "ArrowRight": Handle("→", "a second on (with Shift a tenth)", "step,1"),
    "PageUp": Handle("Page ↑", "ten seconds back", "step,-10"),
    "PageDown": Handle("Page ↓", "ten seconds on", "step,10"),
    "Home": Handle("Home", "the first moment that is kept", "begin"),
    "End": Handle("End", "the run as it is", "live"),
    "Escape": Handle("Esc", "the run as it is", "live"),
    " ": Handle("Space", "play from here, or stop here", "play"),
}
"""By KeyboardEvent.key: pressed while the time line's handle has the focus."""
CELLS = {
    "ArrowUp": Cell("↑", "the cell before", -1),
    "ArrowLeft": Cell("←", "the cell before", -1),
    "ArrowDown": Cell("↓", "the next cell", 1),
    "ArrowRight": Cell("→", "the next cell", 1),
    "Enter": Cell("Enter", "press it", 0),
    " ": Cell("Space", "press it", 0),
}
"""By KeyboardEvent.key: pressed while a cell that can be pressed has the focus."""
OF_VISER = (
    (("Ctrl K",), "all commands, to search"),
    (("W", "S"), "camera forward and back"),
    (("A", "D"), "camera left and right"),
    (("Q", "E"), "camera down and up"),
    (("←", "→", "↑", "↓"), "turn the camera"),
)
"""Keys that viser binds, and what they do."""


def driving_keys() -> list[tuple[str, list[str]]]:
    """Ahead, left, back and right: the sign of the arrow key, and the codes of all keys that do it."""
    found: dict[tuple[int, int], tuple[str, list[str]]] = {}
    for code, key in DRIVING.items():
        shown, codes = found.get(key.signs, ("", []))
        found[key.signs] = (key.shown if code.startswith("Arrow") else shown, [*codes, code])
    return [found[signs] for signs in ((1, 0), (0, 1), (-1, 0), (0, -1))]


def bind(gui: viser.GuiApi, name: str, icon: viser.IconName, on_trigger: Callable[[Any], None]) -> None:
    """Add a command with its key; the command palette (Ctrl-K) lists it too."""
    key, meaning = COMMANDS[name]
    command = gui.add_command(name, description=meaning or None, hotkey=key, icon=icon)  # type: ignore[arg-type]
    command.on_trigger(on_trigger)


class Group(NamedTuple):
    """Keys that work at one place."""

    where: str
    rows: list[tuple[tuple[str, ...], str]]
    """Keys as they are shown, and what they do."""


def groups() -> list[Group]:
    """All keys as the help lists them."""
    commands = [((key,), f"{name}: {meaning}" if meaning else name) for name, (key, meaning) in COMMANDS.items()]
    return [
        Group("Anywhere", [((HELP,), "this help; Esc closes it"), *commands]),
        Group("On the handle of the time line", _together((one.shown, one.meaning) for one in HANDLE.values())),
        Group("On a cell of a table (Tab goes there)", _together((one.shown, one.meaning) for one in CELLS.values())),
        Group("On the page that has the wheel", _together((one.shown, one.meaning) for one in DRIVING.values())),
        Group("Of the viewer, on pages without the wheel", list(OF_VISER)),
    ]


def _together(keys: Any) -> list[tuple[tuple[str, ...], str]]:
    """Keys of one meaning in a row."""
    rows: dict[str, tuple[str, ...]] = {}
    for shown, meaning in keys:
        rows[meaning] = (*rows.get(meaning, ()), shown)
    return [(shown, meaning) for meaning, shown in rows.items()]
