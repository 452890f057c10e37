"""The fault panel: what is wrong with a link, as the world has it, and the means to change it."""

from collections.abc import Callable, Mapping
from time import monotonic
from typing import Any

import viser

from dashboard import tables
from dashboard.desk import Desk
from formation.faults import PERFECT, PRESETS, plan_links
from formation.pattern import downstream, upstream
from network.control import SetPreset
from network.messages import State

ALL = "All links"
PICK = "choose…"
HANDS_OFF_SECONDS = 0.8
"""A control that a person just moved is not set back before the world has had time to follow."""
FOR_SECONDS = 10.0

_SLIDERS = (
    # key, label, full scale, step, factor from the world's unit to the slider's
    ("latency", "Latency ms", 1000.0, 10.0, 1e3),
    ("jitter", "Jitter ms", 300.0, 5.0, 1e3),
    ("loss", "Loss %", 100.0, 1.0, 1e2),
    ("burst", "Burst length", 50.0, 1.0, 1.0),
)
_MORE = (
    ("duplicate", "Duplicate %", 100.0, 1.0, 1e2),
    ("reorder", "Reorder %", 100.0, 1.0, 1e2),
    ("corrupt", "Corrupt %", 100.0, 1.0, 1e2),
    ("rate", "At most /s", 200.0, 5.0, 1.0),
)


class FaultPanel:
    """Controls of the faults, in the current folder of the page."""

    def __init__(self, gui: viser.GuiApi, desk: Desk) -> None:
        self._desk = desk
        self._robots = 0
        self._moved: dict[str, float] = {}
        self._controls: dict[str, tuple[Any, float]] = {}
        with gui.add_folder("Communication faults"):
            self._target: Any = gui.add_dropdown("Target", (ALL,), initial_value=ALL)
            self._in_force = gui.add_html("")
            self._preset: Any = gui.add_dropdown("Preset", (PICK, *PRESETS), initial_value=PICK)
            self._cut = gui.add_checkbox("Cut", False, hint="Nothing passes")
            for slider in _SLIDERS:
                self._add_slider(gui, *slider)
            self._timed = gui.add_checkbox(
                f"For {FOR_SECONDS:.0f} s", False, hint="What is set next ends by itself after so much simulated time"
            )
            self._clear = gui.add_button("Clear this target", color="gray", hint="Take back what was set on it")
            with gui.add_folder("More faults", expand_by_default=False):
                for slider in _MORE:
                    self._add_slider(gui, *slider)
        self._target.on_update(lambda event: self._moved.clear())
        self._cut.on_update(lambda event: self._set(event, "cut", bool(event.target.value)))
        self._preset.on_update(self._use_preset)
        self._clear.on_click(lambda event: self._desk.clear(self.target, event.client_id))

    def _add_slider(self, gui: viser.GuiApi, key: str, label: str, top: float, step: float, factor: float) -> None:
        slider = gui.add_slider(label, 0.0, top, step, 0.0)
        slider.on_update(lambda event: self._set(event, key, float(event.target.value) / factor))
        self._controls[key] = (slider, factor)

    # ------------------------------------------------------------------ what people do

    @property
    def target(self) -> tuple[str, ...]:
        """The links that are chosen, as the world names them."""
        return _links_of(self._target.value, self._robots)

    def choose(self, sender: int) -> None:
        """Choose the link with this sender, in the ring."""
        label = f"{sender} → {downstream(sender, self._robots)}"
        if label in self._target.options:
            self._moved.clear()
            self._target.value = label

    def _seconds(self) -> float | None:
        return FOR_SECONDS if self._timed.value else None

    def _set(self, event: viser.GuiEvent[Any], key: str, value: float | bool) -> None:
        if event.client_id is None:  # the page follows the world; nobody moved it
            return
        self._moved[key] = monotonic()
        self._desk.change(self.target, {key: value}, self._seconds(), event.client_id)

    def _use_preset(self, event: viser.GuiEvent[Any]) -> None:
        name = event.target.value
        if event.client_id is None or name == PICK:
            return
        self._moved.clear()
        for link in self.target:
            seconds = self._seconds()
            operation = (
                SetPreset(link=link, preset=name)
                if seconds is None
                else SetPreset(link=link, preset=name, seconds=seconds)
            )
            self._desk.ask(operation, event.client_id)
        self._preset.value = PICK

    # ------------------------------------------------------------------ what the world says

    def draw(self, state: State) -> None:
        """Show what the world has."""
        if len(state.poses) != self._robots:
            self._robots = len(state.poses)
            chosen = self._target.value
            options = targets(self._robots)
            self._target.options = options
            self._target.value = chosen if chosen in options else ALL
        _assign(self._in_force, "content", tables.in_force(state))
        fault = worst(state.faults, self.target, self._robots)
        self._follow("cut", self._cut, bool(fault["cut"]))
        for key, (slider, factor) in self._controls.items():
            self._follow(key, slider, min(round(factor * float(fault[key]), 6), slider.max))

    def _follow(self, key: str, control: Any, value: float | bool) -> None:
        if control.value != value and monotonic() - self._moved.get(key, 0.0) > HANDS_OFF_SECONDS:
            control.value = value


def _assign(handle: Any, name: str, value: object) -> None:
    if getattr(handle, name) != value:
        setattr(handle, name, value)


def targets(robots: int) -> tuple[str, ...]:
    """What can be chosen."""
    ring = [link.replace("->", " → ") for link in plan_links(robots)]
    both = [f"Robot {i}: from and to" for i in range(1, robots + 1)]
    poses = [f"world → {i}" for i in range(1, robots + 1)]
    commands = [f"{i} → world" for i in range(1, robots + 1)]
    return (ALL, *ring, *both, *poses, *commands)


def _links_of(label: str, robots: int) -> tuple[str, ...]:
    if label == ALL:
        return ("all",)
    if label.startswith("Robot "):
        robot = int(label.split()[1].rstrip(":"))
        return f"{upstream(robot, robots)}->{robot}", f"{robot}->{downstream(robot, robots)}"
    return (label.replace(" → ", "->"),)


def worst(faults: Mapping[str, Mapping[str, Any]], target: tuple[str, ...], robots: int) -> dict[str, Any]:
    """The largest value of every key over the chosen links."""
    links = plan_links(robots) if target == ("all",) else target
    shown = [PERFECT.model_dump() | dict(faults.get(link, {})) for link in links]
    perfect: Callable[[str], Any] = lambda key: max(fault[key] for fault in shown)  # noqa: E731
    return {key: perfect(key) for key in ("cut", *(row[0] for row in (*_SLIDERS, *_MORE)))}
