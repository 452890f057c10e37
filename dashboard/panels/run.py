"""The run panel: how the run is; start, pause, step, reset, scenario, controller, speed. Labels follow the world."""

from typing import Any

import viser

from dashboard.panels.comparison import comparison
from dashboard.panels.controls import MirroredControl, assign
from dashboard.panels.requests import RequestQueue
from dashboard.panels.summary import head
from dashboard.telemetry.history import History
from dashboard.telemetry.links import LinkView
from dashboard.telemetry.subscriber import Snapshot
from formation.scenario.files import shipped
from formation.scenario.registry import LIVE, NAMES
from network.control import Clear, Compare, Operation, Pause, Reset, Speed, Start, Step, UseController, UseScenario
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
ALONE = "nothing"
COMPARE_HINT = "Flies this controller beside the live one, as a ghost that meets the very same faults"


class RunPanel:
    """Controls of the run, in the current container of the page."""

    def __init__(self, gui: viser.GuiApi, requests: RequestQueue) -> None:
        self._requests = requests
        self._status = ""
        self._head = gui.add_html("")
        self._toggle = gui.add_button("Start", icon=viser.Icon.PLAYER_PLAY)
        self._actions = gui.add_button_group("Run", ("Step", "Reset", "Clear faults"))
        self._scenario = MirroredControl(gui.add_dropdown("Scenario", tuple(shipped())))
        self._controller = MirroredControl(gui.add_dropdown("Controller", LIVE))
        self._compare = MirroredControl(gui.add_dropdown("Compare with", (ALONE, *NAMES), hint=COMPARE_HINT))
        self._verdict = gui.add_html("")
        self._speed = MirroredControl(gui.add_dropdown("Speed", tuple(SPEEDS), initial_value="1 x real time"))
        self._toggle.on_click(lambda event: self._switch(event.client_id))
        self._actions.on_click(lambda event: self._act(event.target.value, event.client_id))
        self._scenario.control.on_update(lambda event: self._person(event, lambda name: UseScenario(scenario=name)))
        self._controller.control.on_update(
            lambda event: self._person(event, lambda name: UseController(controller=name))
        )
        self._compare.control.on_update(lambda event: self._person(event, _compare))
        self._speed.control.on_update(lambda event: self._person(event, lambda name: Speed(speed=_speed(name))))
        self._add_commands(gui)

    def _add_commands(self, gui: viser.GuiApi) -> None:
        """Shortcuts; they stand in the command palette (Ctrl-K) too."""
        pause = gui.add_command("Start or pause", hotkey="P", icon=viser.Icon.PLAYER_PLAY)
        pause.on_trigger(lambda event: self._switch(event.client_id))
        step = gui.add_command("Step", description=f"{STEP_TICKS} ticks", hotkey="S", icon=viser.Icon.PLAYER_TRACK_NEXT)
        step.on_trigger(lambda event: self._act("Step", event.client_id))
        reset = gui.add_command("Reset", description="Start the flight again", hotkey="R", icon=viser.Icon.REFRESH)
        reset.on_trigger(lambda event: self._act("Reset", event.client_id))
        clear = gui.add_command("Clear all faults", hotkey="C", icon=viser.Icon.ERASER)
        clear.on_trigger(lambda event: self._act("Clear faults", event.client_id))

    # ------------------------------------------------------------------ what people do

    def _switch(self, page: int | None) -> None:
        self._requests.ask(Pause() if self._status == "running" else Start(), page)

    def _act(self, name: str, page: int | None) -> None:
        operations: dict[str, Operation] = {"Step": Step(ticks=STEP_TICKS), "Reset": Reset(), "Clear faults": Clear()}
        if name in operations:
            self._requests.ask(operations[name], page)

    def _person(self, event: viser.GuiEvent[Any], operation: Any) -> None:
        # A page may send anything; a scenario by its path must not be read for it.
        if event.client_id is not None and event.target.value in event.target.options:
            self._requests.ask(operation(event.target.value), event.client_id)

    # ------------------------------------------------------------------ what the world says

    def draw(self, snapshot: Snapshot, links: list[LinkView], history: History) -> None:
        """Show how the run is."""
        assign(self._head, "content", head(snapshot, links))
        state = snapshot.state
        if state is None:
            return
        self._status = state.status if snapshot.world_alive else ""
        label, icon = _LABELS[state.status]
        if self._toggle.label != label:
            self._toggle.label = label
            self._toggle.icon = icon
        _choose(self._scenario, state.scenario)
        _choose(self._controller, state.controller)
        _choose(self._compare, state.compare or ALONE)
        assign(self._verdict, "content", comparison(state, history))
        _choose(self._speed, _speed_name(state))


_LABELS = {
    "running": ("Pause", viser.Icon.PLAYER_PAUSE),
    "paused": ("Start", viser.Icon.PLAYER_PLAY),
    "waiting": ("Start", viser.Icon.PLAYER_PLAY),
    "finished": ("Fly again", viser.Icon.REPEAT),
}


def _compare(name: str) -> Operation:
    return Compare.model_validate({"controller": "off" if name == ALONE else name})


def _speed(name: str) -> float:
    return SPEEDS[name] if name in SPEEDS else float(name.split(maxsplit=1)[0])


def _speed_name(state: State) -> str:
    names = [name for name, speed in SPEEDS.items() if abs(speed - state.speed) < 1e-9]
    return names[0] if names else f"{state.speed:g} x"


def _choose(dropdown: MirroredControl, value: str) -> None:
    """Show this value, also if it is not one of the shipped ones."""
    if value not in dropdown.control.options:
        dropdown.control.options = (*dropdown.control.options, value)
    dropdown.follow(value)
