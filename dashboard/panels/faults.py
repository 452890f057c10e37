"""The fault panel: what is wrong with a link, as the world has it, and the means to change it."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import viser

from dashboard.panels import tables
from dashboard.panels.controls import MirroredControl, assign, set_options
from dashboard.panels.requests import RequestQueue
from formation.faults import PERFECT, PRESETS, plan_links
from formation.pattern import downstream, upstream
from network.control import SetPreset
from network.messages import State

ALL = "All links"
PICK = "choose…"
FOR_SECONDS = 10.0


@dataclass(frozen=True, slots=True)
class Row:
    """A slider for one key of a fault."""

    key: str
    label: str
    top: float
    step: float
    factor: float
    """From the world's unit to the slider's."""


SLIDERS = (
    Row("latency", "Latency ms", 1000.0, 10.0, 1e3),
    Row("jitter", "Jitter ms", 300.0, 5.0, 1e3),
    Row("loss", "Loss %", 100.0, 1.0, 1e2),
    Row("burst", "Burst length", 50.0, 1.0, 1.0),
)
MORE = (
    Row("duplicate", "Duplicate %", 100.0, 1.0, 1e2),
    Row("reorder", "Reorder %", 100.0, 1.0, 1e2),
    Row("corrupt", "Corrupt %", 100.0, 1.0, 1e2),
    Row("rate", "At most /s", 200.0, 5.0, 1.0),
)


class FaultPanel:
    """Controls of the faults, in the current folder of the page."""

    def __init__(self, gui: viser.GuiApi, requests: RequestQueue) -> None:
        self._requests = requests
        self._robots = 0
        self._sliders: dict[str, tuple[MirroredControl, float]] = {}
        with gui.add_folder("Communication faults"):
            self._target: Any = gui.add_dropdown("Target", (ALL,), initial_value=ALL)
            self._in_force = gui.add_html("")
            self._preset: Any = gui.add_dropdown("Preset", (PICK, *PRESETS), initial_value=PICK)
            self._cut = MirroredControl(gui.add_checkbox("Cut", False, hint="Nothing passes"))
            for row in SLIDERS:
                self._add_slider(gui, row)
            self._timed = gui.add_checkbox(
                f"For {FOR_SECONDS:.0f} s", False, hint="What is set next ends by itself after so much simulated time"
            )
            self._clear = gui.add_button("Clear this target", color="gray", hint="Take back what was set on it")
            with gui.add_folder("More faults", expand_by_default=False):
                for row in MORE:
                    self._add_slider(gui, row)
        self._target.on_update(lambda _: self._release())
        self._cut.control.on_update(lambda event: self._set(event, "cut", bool(event.target.value)))
        self._preset.on_update(self._use_preset)
        self._clear.on_click(lambda event: self._requests.clear(self.target, event.client_id))

    def _add_slider(self, gui: viser.GuiApi, row: Row) -> None:
        slider = gui.add_slider(row.label, 0.0, row.top, row.step, 0.0)
        slider.on_update(lambda event: self._set(event, row.key, float(event.target.value) / row.factor))
        self._sliders[row.key] = (MirroredControl(slider), row.factor)

    # ------------------------------------------------------------------ what people do

    @property
    def target(self) -> tuple[str, ...]:
        """The links that are chosen, as the world names them; none if a page chose what is not offered."""
        label = self._target.value
        return _links_of(label, self._robots) if label in self._target.options else ()

    def choose(self, verb: str, number: int) -> None:
        """Choose a target: "link" with this sender in the ring, "both" links of this robot, or "all"."""
        label = {"link": f"{number} → {downstream(number, self._robots)}", "both": f"Robot {number}: from and to"}
        wished = label.get(verb, ALL)
        if wished in self._target.options:
            self._target.value = wished

    def _seconds(self) -> float | None:
        return FOR_SECONDS if self._timed.value else None

    def _set(self, event: viser.GuiEvent[Any], key: str, value: float | bool) -> None:
        if event.client_id is None:  # the page follows the world; nobody moved it
            return
        self._requests.change(self.target, {key: value}, self._seconds(), event.client_id, at_once=key == "cut")

    def _use_preset(self, event: viser.GuiEvent[Any]) -> None:
        name = event.target.value
        if event.client_id is None or name == PICK:
            return
        self._release()
        for link in self.target:
            seconds = self._seconds()
            operation = (
                SetPreset(link=link, preset=name)
                if seconds is None
                else SetPreset(link=link, preset=name, seconds=seconds)
            )
            self._requests.ask(operation, event.client_id)
        self._preset.value = PICK

    # ------------------------------------------------------------------ what the world says

    def draw(self, state: State) -> None:
        """Show what the world has."""
        self._robots = len(state.poses)
        set_options(self._target, targets(self._robots))
        assign(self._in_force, "content", tables.in_force(state))
        fault = worst(state.faults, self.target, self._robots)
        self._cut.follow(bool(fault["cut"]))
        for key, (slider, factor) in self._sliders.items():
            slider.follow(min(round(factor * float(fault[key]), 6), slider.control.max))

    def _release(self) -> None:
        for follower in (self._cut, *(slider for slider, _ in self._sliders.values())):
            follower.release()


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
    """The largest value of every key over the chosen links; a perfect link's if none is chosen."""
    links = plan_links(robots) if target == ("all",) else target
    shown = [PERFECT.model_dump() | dict(faults.get(link, {})) for link in links] or [PERFECT.model_dump()]
    keys = ("cut", *(row.key for row in (*SLIDERS, *MORE)))
    return {key: max(fault[key] for fault in shown) for key in keys}
