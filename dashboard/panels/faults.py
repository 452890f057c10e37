"""The fault panel: the faults in force, and the controls that change them."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import viser

from dashboard.panels.mirrored_controls import MirroredControl, set_if_changed, set_options
from dashboard.panels.requests import RequestQueue
from dashboard.theme.templates import render
from formation.faults import PERFECT, PRESETS, plan_links
from formation.pattern import downstream, upstream
from network.control import SetPreset
from network.messages import State

ALL = "All links"
PICK = "choose…"
FOR_SECONDS = 10.0


@dataclass(frozen=True, slots=True)
class FaultSlider:
    """A slider for one key of a fault."""

    key: str
    label: str
    top: float
    """Its largest value, in the unit of its label."""
    step: float
    factor: float
    """From the world's unit to the slider's."""


SLIDERS = (
    FaultSlider("latency", "Latency ms", 1000.0, 10.0, 1e3),
    FaultSlider("jitter", "Jitter ms", 300.0, 5.0, 1e3),
    FaultSlider("loss", "Loss %", 100.0, 1.0, 1e2),
    FaultSlider("burst", "Burst length", 50.0, 1.0, 1.0),
)
MORE = (
    FaultSlider("duplicate", "Duplicate %", 100.0, 1.0, 1e2),
    FaultSlider("reorder", "Reorder %", 100.0, 1.0, 1e2),
    FaultSlider("corrupt", "Corrupt %", 100.0, 1.0, 1e2),
    FaultSlider("rate", "At most /s", 200.0, 5.0, 1.0),
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
            self._cut = MirroredControl(gui.add_checkbox("Cut", False, hint="No message passes"))
            for spec in SLIDERS:
                self._add_slider(gui, spec)
            self._timed = gui.add_checkbox(
                f"For {FOR_SECONDS:.0f} s", False, hint="Faults set from now on end after so much simulated time"
            )
            self._clear = gui.add_button("Clear this target", color="gray", hint="Remove all faults from the target")
            with gui.add_folder("More faults", expand_by_default=False):
                for spec in MORE:
                    self._add_slider(gui, spec)
        self._target.on_update(lambda _: self._release())
        self._cut.control.on_update(lambda event: self._set(event, "cut", bool(event.target.value)))
        self._preset.on_update(self._use_preset)
        self._clear.on_click(lambda event: self._requests.clear(self.target, event.client_id))

    def _add_slider(self, gui: viser.GuiApi, spec: FaultSlider) -> None:
        slider = gui.add_slider(spec.label, 0.0, spec.top, spec.step, 0.0)
        slider.on_update(lambda event: self._set(event, spec.key, float(event.target.value) / spec.factor))
        self._sliders[spec.key] = (MirroredControl(slider), spec.factor)

    # ------------------------------------------------------------------ from the user to the world

    @property
    def target(self) -> tuple[str, ...]:
        """Names of the links that are the target, as in the world; none if a page sent a target that is not offered."""
        label = self._target.value
        return _links_of(label, self._robots) if label in self._target.options else ()

    def choose(self, verb: str, number: int) -> None:
        """Choose the target: "link" with this sender in the ring, "both" links of this robot, or "all"."""
        label = {"link": f"{number} → {downstream(number, self._robots)}", "both": f"Robot {number}: from and to"}
        chosen = label.get(verb, ALL)
        if chosen in self._target.options:
            self._target.value = chosen

    def _seconds(self) -> float | None:
        return FOR_SECONDS if self._timed.value else None

    def _set(self, event: viser.GuiEvent[Any], key: str, value: float | bool) -> None:
        if event.client_id is None:  # set by `draw`, not by a user
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

    # ------------------------------------------------------------------ from the world to the panel

    def draw(self, state: State) -> None:
        """Show the faults in force in the world."""
        self._robots = len(state.poses)
        set_options(self._target, targets(self._robots))
        set_if_changed(self._in_force, "content", in_force(state.faults))
        fault = worst(state.faults, self.target, self._robots)
        self._cut.show(bool(fault["cut"]))
        for key, (slider, factor) in self._sliders.items():
            slider.show(min(round(factor * float(fault[key]), 6), slider.control.max))

    def _release(self) -> None:
        for control in (self._cut, *(slider for slider, _ in self._sliders.values())):
            control.release()


def in_force(faults: Mapping[str, Mapping[str, Any]]) -> str:
    """HTML of the faults in force, a line per link."""
    return render("panels/faults_in_force.html", faults=faults)


def targets(robots: int) -> tuple[str, ...]:
    """Labels of the targets that can be chosen."""
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
    keys = ("cut", *(spec.key for spec in (*SLIDERS, *MORE)))
    return {key: max(fault[key] for fault in shown) for key in keys}
