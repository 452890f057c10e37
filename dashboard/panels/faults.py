"""The fault panel: what is wrong with a link, as the world has it, and the means to change it."""

from collections.abc import Mapping
from functools import partial
from typing import Any

import viser

from dashboard.panels import tables
from dashboard.panels.controls import MirroredControl, assign, set_options
from dashboard.panels.requests import RequestQueue
from formation.faults import PERFECT, PRESETS, SHOWN, Fault
from formation.links import LinkId, plan_links
from network.control import SetPreset
from network.messages import State

ALL = "All links"
PICK = "choose…"
FOR_SECONDS = 10.0
SLIDERS = {key: shown for key, shown in SHOWN.items() if shown.top > 0.0}
"""Keys of a fault that have one."""


class FaultPanel:
    """Controls of the faults, in the current folder of the page."""

    def __init__(self, gui: viser.GuiApi, requests: RequestQueue) -> None:
        self._requests = requests
        self._robots = 0
        self._sliders: dict[str, MirroredControl] = {}
        with gui.add_folder("Communication faults"):
            self._target: Any = gui.add_dropdown("Target", (ALL,), initial_value=ALL)
            self._in_force = gui.add_html("")
            self._preset: Any = gui.add_dropdown("Preset", (PICK, *PRESETS), initial_value=PICK)
            self._cut = MirroredControl(gui.add_checkbox("Cut", False, hint="Nothing passes"))
            self._add_sliders(gui, often=True)
            self._timed = gui.add_checkbox(
                f"For {FOR_SECONDS:.0f} s", False, hint="What is set next ends by itself after so much simulated time"
            )
            self._clear = gui.add_button("Clear this target", color="gray", hint="Take back what was set on it")
            with gui.add_folder("More faults", expand_by_default=False):
                self._add_sliders(gui, often=False)
        self._target.on_update(lambda _: self._release())
        self._cut.control.on_update(lambda event: self._set(event, "cut", bool(event.target.value)))
        self._preset.on_update(self._use_preset)
        self._clear.on_click(lambda event: self._requests.clear(self.target, event.client_id))

    def _add_sliders(self, gui: viser.GuiApi, *, often: bool) -> None:
        for key, shown in SLIDERS.items():
            if shown.often == often:
                slider = gui.add_slider(f"{shown.label} {shown.unit}".strip(), 0.0, shown.top, shown.step, 0.0)
                slider.on_update(partial(self._moved, key))
                self._sliders[key] = MirroredControl(slider)

    def _moved(self, key: str, event: viser.GuiEvent[Any]) -> None:
        self._set(event, key, float(event.target.value) / SLIDERS[key].factor)

    # ------------------------------------------------------------------ what people do

    @property
    def target(self) -> tuple[str, ...]:
        """The links that are chosen, as the world names them; none if a page chose what is not offered."""
        label = self._target.value
        return targets(self._robots).get(label, ()) if label in self._target.options else ()

    def choose(self, verb: str, number: int) -> None:
        """Choose a target: "link" with this sender in the ring, "both" links of this robot, or "all"."""
        label = {"link": arrow(LinkId.plans_from(number, self._robots)), "both": f"Robot {number}: from and to"}
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
        set_options(self._target, tuple(targets(self._robots)))
        assign(self._in_force, "content", tables.in_force(state))
        fault = worst(state.faults, self.target, self._robots)
        self._cut.follow(bool(fault["cut"]))
        for key, slider in self._sliders.items():
            slider.follow(min(round(SLIDERS[key].shown(float(fault[key])), 6), slider.control.max))

    def _release(self) -> None:
        for follower in (self._cut, *self._sliders.values()):
            follower.release()


def targets(robots: int) -> dict[str, tuple[str, ...]]:
    """What can be chosen, and the names of the links that it stands for."""
    numbers = range(1, robots + 1)
    own = [*(LinkId.poses_to(i) for i in numbers), *(LinkId.commands_from(i) for i in numbers)]
    return {
        ALL: ("all",),
        **{arrow(link): (str(link),) for link in plan_links(robots)},
        **{
            f"Robot {i}: from and to": (str(LinkId.plans_to(i, robots)), str(LinkId.plans_from(i, robots)))
            for i in numbers
        },
        **{arrow(link): (str(link),) for link in own},
    }


def arrow(link: LinkId) -> str:
    """The link as the page writes it."""
    return str(link).replace("->", " → ")


def worst(faults: Mapping[LinkId, Fault], target: tuple[str, ...], robots: int) -> dict[str, Any]:
    """The largest value of every key over the chosen links; a perfect link's if none is chosen."""
    links = plan_links(robots) if target == ("all",) else [LinkId.parse(name) for name in target]
    shown = [faults.get(link, PERFECT) for link in links] or [PERFECT]
    return {key: max(getattr(fault, key) for fault in shown) for key in ("cut", *SLIDERS)}
