"""The fault panel: the faults in force, and the controls that change them."""

from collections.abc import Collection, Mapping
from functools import lru_cache, partial
from typing import Any

import viser

from dashboard.edits import Edit, on_edit, set_value
from dashboard.panels.mirrored_controls import MirroredControl, set_if_changed, set_options
from dashboard.requests import RequestQueue
from dashboard.theme.templates import render
from formation.faults import PERFECT, PRESETS, SHOWN, Fault
from formation.link_ids import DRIVING, LinkId, plan_links
from network.control import SetPreset
from network.messages import State

ALL = "All links"
PICK = "choose…"
FOR_SECONDS = 10.0
SLIDERS = {key: shown for key, shown in SHOWN.items() if shown.top > 0.0}
"""Keys of a fault that have a slider."""


class FaultPanel:
    """Controls of the faults, in the current folder of the page."""

    def __init__(self, gui: viser.GuiApi, requests: RequestQueue) -> None:
        """Add the folder; of a record its controls are off."""
        self._requests = requests
        self._robots, self._driven, self._away = 0, False, list[int]()
        self._sliders: dict[str, MirroredControl] = {}
        with gui.add_folder("Communication faults"):
            self._target: Any = gui.add_dropdown("Target", (ALL,), initial_value=ALL)
            self._in_force = gui.add_html("")
            self._preset: Any = gui.add_dropdown("Preset", (PICK, *PRESETS), initial_value=PICK)
            self._cut = MirroredControl(gui.add_checkbox("Cut", False, hint="No message passes"))
            self._add_sliders(gui, often=True)
            self._timed = gui.add_checkbox(
                f"For {FOR_SECONDS:.0f} s", False, hint="Faults set from now on end after so much simulated time"
            )
            self._clear = gui.add_button("Clear this target", color="gray", hint="Remove all faults from the target")
            with gui.add_folder("More faults", expand_by_default=False):
                self._add_sliders(gui, often=False)
        on_edit(self._target, lambda _: self._release())
        on_edit(self._cut.control, lambda edit: self._set(edit, "cut", bool(edit.value)))
        on_edit(self._preset, self._use_preset)
        on_edit(self._clear, lambda edit: self._requests.clear(self.target, edit.page))
        if not requests.possible:
            sliders = (slider.control for slider in self._sliders.values())
            for control in (self._preset, self._cut.control, self._timed, self._clear, *sliders):
                control.disabled = True

    def _add_sliders(self, gui: viser.GuiApi, *, often: bool) -> None:
        for key, shown in SLIDERS.items():
            if shown.often == often:
                slider = gui.add_slider(f"{shown.label} {shown.unit}".strip(), 0.0, shown.top, shown.step, 0.0)
                on_edit(slider, partial(self._slider_moved, key))
                self._sliders[key] = MirroredControl(slider)

    def _slider_moved(self, key: str, edit: Edit) -> None:
        self._set(edit, key, float(edit.value) / SLIDERS[key].factor)

    # ------------------------------------------------------------------ from the user to the world

    @property
    def target(self) -> tuple[str, ...]:
        """Names of the links that are the target, as in the world; none if a page sent a target that is not offered."""
        label = self._target.value
        return (
            targets(self._robots, driven=self._driven, away=self._away).get(label, ())
            if label in self._target.options
            else ()
        )

    def choose(self, verb: str, number: int) -> None:
        """Choose the target: "link" with this sender in the ring, "both" links of this robot, "driver", or "all"."""
        link = arrow(LinkId.plans_from(number, self._robots, self._away))
        label = {"driver": arrow(DRIVING), "link": link, "both": f"Robot {number}: from and to"}
        chosen = label.get(verb, ALL)
        if chosen in self._target.options:
            set_value(self._target, chosen)
            self._release()

    def _seconds(self) -> float | None:
        return FOR_SECONDS if self._timed.value else None

    def _set(self, edit: Edit, key: str, value: float | bool) -> None:
        self._requests.change(self.target, {key: value}, self._seconds(), edit.page, at_once=key == "cut")

    def _use_preset(self, edit: Edit) -> None:
        name = edit.value
        if name == PICK:
            return
        self._release()
        for link in self.target:
            seconds = self._seconds()
            operation = (
                SetPreset(link=link, preset=name)
                if seconds is None
                else SetPreset(link=link, preset=name, seconds=seconds)
            )
            self._requests.ask(operation, edit.page)
        set_value(self._preset, PICK)

    # ------------------------------------------------------------------ from the world to the panel

    def draw(self, state: State, *, driven: bool) -> None:
        """Show the faults in force in the world, of a path that is driven or not."""
        self._robots, self._driven, self._away = len(state.poses), driven, state.away
        set_options(self._target, tuple(targets(self._robots, driven=driven, away=state.away)))
        set_if_changed(self._in_force, "content", in_force(state.faults))
        fault = worst(state.faults, self.target, self._robots, state.away)
        self._cut.show(bool(fault["cut"]))
        for key, slider in self._sliders.items():
            slider.show(min(round(SLIDERS[key].shown(float(fault[key])), 6), slider.control.max))

    def _release(self) -> None:
        for control in (self._cut, *self._sliders.values()):
            control.release()


def in_force(faults: Mapping[LinkId, Fault]) -> str:
    """HTML of the faults in force, a line per link."""
    return render("panels/faults_in_force.html", faults=sorted(faults.items()))


def targets(robots: int, *, driven: bool = False, away: Collection[int] = ()) -> dict[str, tuple[str, ...]]:
    """Labels of the targets that can be chosen, and the names of their links, in a ring of which some are away."""
    return _targets(robots, driven, tuple(sorted(away)))


@lru_cache(maxsize=4)
def _targets(robots: int, driven: bool, away: tuple[int, ...]) -> dict[str, tuple[str, ...]]:  # with every frame
    orders = {arrow(DRIVING): (str(DRIVING),)} if driven else {}
    numbers = range(1, robots + 1)
    own = [*(LinkId.poses_to(i) for i in numbers), *(LinkId.commands_from(i) for i in numbers)]
    return {
        ALL: ("all",),
        **{arrow(link): (str(link),) for link in plan_links(robots, away=away)},
        **orders,
        **{
            f"Robot {i}: from and to": (str(LinkId.plans_to(i, robots, away)), str(LinkId.plans_from(i, robots, away)))
            for i in numbers
            if i not in away
        },
        **{arrow(link): (str(link),) for link in own},
    }


def arrow(link: LinkId) -> str:
    """The link in a label: "1 → 2"."""
    return str(link).replace("->", " → ")


def worst(
    faults: Mapping[LinkId, Fault], target: tuple[str, ...], robots: int, away: Collection[int] = ()
) -> dict[str, Any]:
    """The largest value of every key over the chosen links; a perfect link's if none is chosen."""
    links = plan_links(robots, away=away) if target == ("all",) else [LinkId.parse(name) for name in target]
    shown = [faults.get(link, PERFECT) for link in links] or [PERFECT]
    return {key: max(getattr(fault, key) for fault in shown) for key in ("cut", *SLIDERS)}
