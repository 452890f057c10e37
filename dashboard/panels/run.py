"""The run panel: summary, start, pause, step, reset, scenario, controller, speed. Labels show the world's state."""

from time import monotonic

import viser

from dashboard.edits import Edit, on_edit
from dashboard.keys import bind
from dashboard.panels.comparison import comparison
from dashboard.panels.mirrored_controls import MirroredControl, set_if_changed
from dashboard.panels.run_summary import RECORD, REWOUND, run_summary
from dashboard.requests import RequestQueue
from dashboard.scenario_list import ScenarioList
from dashboard.telemetry.feed import Feed, View
from dashboard.telemetry.snapshot import Snapshot
from dashboard.theme.templates import render
from formation.errors import ScenarioError
from formation.scenario.registry import live, names, told
from network.control import Clear, Compare, Operation, Pause, Reset, Speed, Start, Step, UseController
from network.messages import State

SPEEDS = {
    "0.25 x": 0.25,
    "0.5 x": 0.5,
    "1 x real time": 1.0,
    "2 x": 2.0,
    "5 x": 5.0,
    "10 x": 10.0,
    "as fast as possible": 0.0,
}
STEP_TICKS = 10
NO_GHOST = "nothing"
SCENARIO_HINT = "The run's own, the shipped ones, and the TOML files of the folder that the run was started from"
REFRESH_SECONDS = 5.0
"""Between two looks at that folder."""
COMPARE_HINT = "Simulates this controller beside the run, as a ghost with the very same faults"


class RunPanel:
    """Controls of the run, in the current container of the page."""

    def __init__(self, gui: viser.GuiApi, requests: RequestQueue, scenarios: ScenarioList, feed: Feed) -> None:
        self._requests, self._scenarios, self._feed = requests, scenarios, feed
        self._refreshed = monotonic()
        self._status = ""
        self._summary = gui.add_html("")
        self._toggle = gui.add_button("Start", icon=viser.Icon.PLAYER_PLAY)
        self._actions = gui.add_button_group("Run", ("Step", "Reset", "Clear"))
        self._scenario = MirroredControl(gui.add_dropdown("Scenario", scenarios.labels, hint=SCENARIO_HINT))
        self._controller = MirroredControl(gui.add_dropdown("Controller", live()))
        self._left_out = gui.add_html("")
        self._compare = MirroredControl(gui.add_dropdown("Compare with", (NO_GHOST, *names()), hint=COMPARE_HINT))
        self._comparison = gui.add_html("")
        self._speed = MirroredControl(gui.add_dropdown("Speed", tuple(SPEEDS), initial_value="1 x real time"))
        on_edit(self._toggle, lambda edit: self._switch(edit.page))
        on_edit(self._actions, lambda edit: self._act(edit.value, edit.page))
        on_edit(self._scenario.control, self._choose_scenario, slow=True)
        on_edit(self._controller.control, lambda edit: requests.ask(UseController(controller=edit.value), edit.page))
        on_edit(self._compare.control, lambda edit: requests.ask(_compare(edit.value), edit.page))
        on_edit(self._speed.control, self._choose_speed)
        self._add_commands(gui)
        if not feed.source.live:
            self._actions.visible = False
            for control in (self._scenario, self._controller, self._compare):
                control.control.disabled = True

    def _add_commands(self, gui: viser.GuiApi) -> None:
        bind(gui, "Start or pause", viser.Icon.PLAYER_PLAY, lambda event: self._switch(event.client_id))
        bind(gui, "Step", viser.Icon.PLAYER_TRACK_NEXT, lambda event: self._act("Step", event.client_id))
        bind(gui, "Reset", viser.Icon.REFRESH, lambda event: self._act("Reset", event.client_id))
        bind(gui, "Clear all faults", viser.Icon.ERASER, lambda event: self._act("Clear", event.client_id))

    # ------------------------------------------------------------------ from the user to the world

    def _switch(self, page: int | None) -> None:
        if not self._feed.source.live:
            self._feed.playhead.tell(["play"])
            return
        self._requests.ask(Pause() if self._status == "running" else Start(), page)

    def _act(self, name: str, page: int | None) -> None:
        operations: dict[str, Operation] = {"Step": Step(ticks=STEP_TICKS), "Reset": Reset(), "Clear": Clear()}
        if name in operations:
            self._requests.ask(operations[name], page)

    def _choose_scenario(self, edit: Edit) -> None:
        if edit.value not in self._scenarios.labels:  # the list is read again now and then
            return
        try:
            asked = self._scenarios.operation(edit.value)
        except ScenarioError as error:
            self._requests.refuse("Not done", str(error), edit.page)
        else:
            self._requests.ask(asked, edit.page)

    def _choose_speed(self, edit: Edit) -> None:
        speed = _speed(edit.value)
        if self._feed.source.live:
            self._requests.ask(Speed(speed=speed), edit.page)
        else:
            self._feed.playhead.tell(["speed", str(speed)])

    # ------------------------------------------------------------------ from the world to the panel

    def draw(self, live: View, view: View) -> None:
        """Show the state of the run: numbers of the moment that is looked at, controls as they are now."""
        record, playhead = not self._feed.source.live, self._feed.playhead
        shown = RECORD if record else REWOUND if view.place is not None else None
        set_if_changed(self._summary, "content", run_summary(view.snapshot, view.links, view.beliefs, shown))
        snapshot, state = live.snapshot, live.snapshot.state
        if state is None:
            return
        self._status = state.status if snapshot.world_alive else ""
        label, icon = _PLAYS[playhead.playing] if record else _LABELS[state.status]
        if self._toggle.label != label:
            self._toggle.label = label
            self._toggle.icon = icon
        self._show_scenario(snapshot, state)
        self._offer_controllers(snapshot, state)
        _show(self._controller, state.controller)
        _show(self._compare, state.compare or NO_GHOST)
        compared = comparison(state, self._feed.history, *self._feed.compared(view)) if state.compare else ""
        set_if_changed(self._comparison, "content", compared)
        _show(self._speed, _speed_name(playhead.speed if record else state.speed))

    def _offer_controllers(self, snapshot: Snapshot, state: State) -> None:
        """Offer the controllers that can run this scenario, and say why others are left out."""
        scenario = snapshot.scenario
        fits = told() if scenario is not None and scenario.path.known_to == "leader" else names()
        lives = tuple(name for name in live() if name in fits)
        _offer_only(self._controller, lives, state.controller)
        _offer_only(self._compare, (NO_GHOST, *fits), state.compare or NO_GHOST)
        missing = ", ".join(name for name in live() if name not in fits)
        set_if_changed(self._left_out, "content", render("panels/left_out.html", missing=missing) if missing else "")

    def _show_scenario(self, snapshot: Snapshot, state: State) -> None:
        if monotonic() - self._refreshed >= REFRESH_SECONDS:
            self._refreshed = monotonic()
            self._scenarios.refresh()
        label = self._scenarios.label_of(snapshot.scenario, state.scenario)
        labels = self._scenarios.labels
        set_if_changed(self._scenario.control, "options", labels if label in labels else (*labels, label))
        self._scenario.show(label)


_LABELS = {
    "running": ("Pause", viser.Icon.PLAYER_PAUSE),
    "paused": ("Start", viser.Icon.PLAYER_PLAY),
    "waiting": ("Start", viser.Icon.PLAYER_PLAY),
    "finished": ("Restart", viser.Icon.REPEAT),
}


_PLAYS = {True: ("Stop", viser.Icon.PLAYER_PAUSE), False: ("Play", viser.Icon.PLAYER_PLAY)}
"""Of a record, while it plays and while it does not."""


def _compare(name: str) -> Operation:
    return Compare.model_validate({"controller": "off" if name == NO_GHOST else name})


def _speed(name: str) -> float:
    return SPEEDS[name] if name in SPEEDS else float(name.split(maxsplit=1)[0])


def _speed_name(speed: float) -> str:
    names = [name for name, known in SPEEDS.items() if abs(known - speed) < 1e-9]
    return names[0] if names else f"{speed:g} x"


def _offer_only(dropdown: MirroredControl, values: tuple[str, ...], now: str) -> None:
    """Offer these values, and the world's value even if it is none of them."""
    set_if_changed(dropdown.control, "options", values if now in values else (*values, now))


def _show(dropdown: MirroredControl, value: str) -> None:
    """Show the world's value, also if the dropdown does not offer it."""
    if value not in dropdown.control.options:
        dropdown.control.options = (*dropdown.control.options, value)
    dropdown.show(value)
