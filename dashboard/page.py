"""The page as a whole: its panels, and the loop that keeps them up to date."""

import base64
from functools import partial
from time import monotonic, sleep
from typing import Any

import viser

from dashboard.export.saving import Saving
from dashboard.panels import tables
from dashboard.panels.agent_lifecycle import AgentLifecycle
from dashboard.panels.clickable import Clickable
from dashboard.panels.controls import set_options
from dashboard.panels.faults import FaultPanel
from dashboard.panels.matrix import matrix
from dashboard.panels.notices import Notices
from dashboard.panels.plots import FIRST, SECOND, Chart
from dashboard.panels.requests import RequestQueue
from dashboard.panels.run import RunPanel
from dashboard.scene.cameras import Cameras
from dashboard.scene.scene import LAYERS, Scene
from dashboard.telemetry.export_buffer import ExportBuffer
from dashboard.telemetry.history import History
from dashboard.telemetry.links import LinkView, ring_links
from dashboard.telemetry.subscriber import Snapshot, TelemetrySubscriber
from dashboard.theme.formatting import legend
from dashboard.theme.palette import DARK, LIGHT, Palette
from dashboard.theme.stylesheet import sheet
from network.lifetime import Lifetime
from network.messages import State
from network.throttled_log import ThrottledLog
from network.zenoh_bus import Session

FRAME = 1.0 / 30.0
CROWD_FRAME = 1.0 / 18.0
CROWD = 20
"""With more robots than this fewer frames are drawn: a page without a graphics card could not follow."""
UNWATCHED_FRAME, UNWATCHED_PAUSE = 0.5, 0.05
"""While nobody looks, what the next page will see first is drawn now and then, and what is said is kept as it comes."""
PANEL_INTERVAL = 0.2
PLOT_INTERVAL = 0.25
NOBODY = "none"


class Page:
    """Everything that is shown, and where it comes from."""

    def __init__(self, server: viser.ViserServer, session: Session) -> None:
        """Lay the page out."""
        self._server = server
        self._telemetry = TelemetrySubscriber(session)
        self._notices = Notices(server)
        self._requests = RequestQueue(session, self._telemetry, self._notices.notify)
        self._agent_lifecycle = AgentLifecycle(self._requests)
        self._history = History()
        self._export_buffer = ExportBuffer()
        self._cameras = Cameras(server)
        self._scene = Scene(server, self._focus_on, lambda sender: self._faults.choose("link", sender))
        self._errors = ThrottledLog()
        self._panel_at = self._plot_at = 0.0
        self._told: tuple[object, ...] = ()
        self._kept: tuple[State, bool] | None = None
        self._views: list[LinkView] = []
        self._palette = DARK
        self._turn = 0
        self._apply_theme()
        gui = server.gui
        gui.add_html(sheet())
        self._run = RunPanel(gui, self._requests)
        self._faults = FaultPanel(gui, self._requests)
        self._add_view(gui)
        self._saving = Saving(gui, session.run, self._export_buffer, lambda: self._palette, self._notices.notify)
        self._clickable = Clickable(gui, self._tapped)
        gui.main_panel.dock_left()
        gui.main_panel.set_width(330)
        panel = gui.add_panel()
        with panel.add_tab("Live", viser.Icon.CHART_LINE):
            first = [Chart(gui, plot) for plot in FIRST]
            self._matrix = gui.add_html("")
            self._charts = [*first, *(Chart(gui, plot) for plot in SECOND)]
        with panel.add_tab("Robots", viser.Icon.ROBOT):
            self._robots = gui.add_html("")
        with panel.add_tab("Log", viser.Icon.LIST):
            self._log = gui.add_html("")
        panel.dock_right()
        panel.set_width(400)

    def _apply_theme(self) -> None:
        self._server.gui.configure_theme(
            dark_mode=self._palette.dark,
            show_logo=False,
            show_share_button=False,
            brand_color=(60, 150, 220),
            titlebar_content=viser.theme.TitlebarConfig(
                buttons=(),
                image=viser.theme.TitlebarImage(
                    image_url_light=_logo("#16202c"), image_url_dark=_logo("#f1f4f8"), image_alt="Echelon", href=None
                ),
            ),
        )

    def _add_view(self, gui: viser.GuiApi) -> None:
        with gui.add_folder("View"):
            camera = gui.add_button_group("Camera", ("Fit", "3D", "Follow"))
            light = gui.add_checkbox("Light", False, hint="Light instead of dark, on every page of this run")
            self._focus: Any = gui.add_dropdown("Follow robot", (NOBODY,), initial_value=NOBODY)
            gui.add_html(legend())
            with gui.add_folder("Layers", expand_by_default=False):
                for name in LAYERS:
                    box = gui.add_checkbox(name, True)
                    box.on_update(partial(self._show_layer, name))
        light.on_update(lambda event: self._choose_look(LIGHT if event.target.value else DARK))
        camera.on_click(lambda event: self._look(event.target.value, event.client))
        self._focus.on_update(self._focus_chosen)
        for name, key in (("Fit", "F"), ("3D", "D"), ("Follow", "G")):
            command = gui.add_command(f"View: {name}", hotkey=key, icon=viser.Icon.CAMERA)  # type: ignore[arg-type]
            command.on_trigger(partial(self._look_at, name))

    # ------------------------------------------------------------------ what people do

    def _show_layer(self, name: str, event: viser.GuiEvent[Any]) -> None:
        self._scene.show_layer(name, bool(event.target.value))

    def _choose_look(self, palette: Palette) -> None:
        self._palette = palette
        self._apply_theme()
        for chart in self._charts:
            chart.set_palette(palette)

    def _look_at(self, how: str, event: Any) -> None:
        self._look(how, event.client)

    def _look(self, how: str, client: viser.ClientHandle | None) -> None:
        if client is None:
            return
        if how == "3D":
            self._cameras.tip(client)
        elif how == "Follow":
            self._cameras.follow(client)
        else:
            self._cameras.fit(client)
            self._scene.focus, self._focus.value = None, NOBODY

    def _focus_chosen(self, event: viser.GuiEvent[Any]) -> None:
        name = event.target.value
        if event.client is None or name not in self._focus.options:  # a page may send anything
            return
        self._scene.focus = None if name == NOBODY else int(name.split()[-1])
        if self._scene.focus is None:
            self._cameras.release(event.client)
        else:
            self._cameras.follow(event.client, self._scene.focus)

    def _focus_on(self, client: viser.ClientHandle, robot: int) -> None:
        name = f"Robot {robot}"
        if name in self._focus.options:
            self._scene.focus, self._focus.value = robot, name
            self._cameras.follow(client, robot)

    def _tapped(self, verb: str, number: int, event: viser.GuiEvent[Any]) -> None:
        """A person pressed a cell of a table."""
        if event.client is None:
            return
        if verb == "focus":
            self._focus_on(event.client, number)
        elif verb in ("kill", "restart"):
            self._agent_lifecycle.pressed(verb, number, event.client)
        else:
            self._faults.choose(verb, number)

    # ------------------------------------------------------------------ the loop

    def serve(self, lifetime: Lifetime) -> None:
        """Keep the page up to date until told to end; a frame that cannot be drawn is passed over."""
        self._telemetry.start()
        self._requests.start()
        due, robots = monotonic(), 0
        while not lifetime.over:
            try:
                robots = self._frame() if self._due else len(self._keep()[0].poses)
            except Exception:
                self._errors.add_exception("drawing a frame")
            due = max(due + self._pause(robots), monotonic())
            sleep(max(0.0, due - monotonic()))
        self._requests.stop()
        self._telemetry.stop()

    @property
    def _watched(self) -> bool:
        return bool(self._server.get_clients())

    @property
    def _due(self) -> bool:
        """Whether to draw now."""
        return self._watched or monotonic() - self._panel_at >= UNWATCHED_FRAME

    def _pause(self, robots: int) -> float:
        """From this frame to the next [s]."""
        if not self._watched:
            return UNWATCHED_PAUSE
        return CROWD_FRAME if robots > CROWD else FRAME

    def _keep(self) -> tuple[Snapshot, list[LinkView]]:
        """What is known now, put down for the plots and for taking away."""
        snapshot = self._telemetry.snapshot()
        state, known = snapshot.state, snapshot.scenario is not None
        if state is not None and known:
            self._history.ghost.update(state, snapshot.ghosts)
        if state is not None and self._kept != (state, known):
            self._kept = state, known
            self._views = ring_links(state, snapshot.statuses)
            if known:
                self._history.add(state, self._views, solves(snapshot))
                self._export_buffer.add(state, self._views, snapshot.statuses)
        return snapshot, self._views

    def _frame(self) -> int:
        """Draw once; returns the number of robots."""
        snapshot, views = self._keep()
        state, whole = snapshot.state, not self._watched
        with self._server.atomic():
            self._scene.set_palette(self._palette)
            self._scene.draw(snapshot, views, self._history, whole=whole)
            now, news = monotonic(), self._news(snapshot)
            panels = now - self._panel_at >= PANEL_INTERVAL or news != self._told
            if panels:
                self._draw_panels(snapshot, views, whole=whole or news != self._told)
                self._panel_at, self._told = now, news
            if whole or (not panels and now - self._plot_at >= PLOT_INTERVAL):
                self._plot_at = now
                series = self._history.series()
                for chart in self._charts:
                    chart.draw(series, ghost=bool(state and state.compare))
        if state is not None and snapshot.scenario is not None and len(snapshot.poses) == snapshot.scenario.size:
            self._cameras.update(snapshot.scenario, snapshot.poses)
        return len(snapshot.poses)

    def _news(self, snapshot: Snapshot) -> tuple[object, ...]:
        """What people see at once when it changes; the rest is drawn some times a second."""
        state, about = (
            snapshot.state,
            (snapshot.world_alive, snapshot.connected, self._faults.target, self._scene.focus),
        )
        if state is None:
            return about
        newest = state.events[-1].number if state.events else 0
        return (
            *about,
            state.episode,
            state.revision,
            state.status,
            state.speed,
            state.compare,
            newest,
            *state.dismissed,
            *state.live,
        )

    def _draw_panels(self, snapshot: Snapshot, views: list[LinkView], *, whole: bool) -> None:
        self._run.draw(snapshot, views, self._history)
        n = len(snapshot.poses)
        self._clickable.set_options(
            {"all": 0, **dict.fromkeys(("link", "both", "focus", "kill", "restart"), n)} if n else {}
        )
        self._matrix.content = matrix(snapshot, views, self._clickable, self._faults.target)
        self._turn += 1
        if whole or self._turn % 2:  # the other tabs take turns: they are read rather than watched
            self._robots.content = tables.robots(snapshot, views, self._clickable)
        if whole or not self._turn % 2:
            self._log.content = tables.log(snapshot.state)
        if snapshot.state is not None:
            self._faults.draw(snapshot.state)
            self._agent_lifecycle.draw(snapshot.state)
            options = (NOBODY, *(f"Robot {i}" for i in range(1, len(snapshot.state.poses) + 1)))
            set_options(self._focus, options)
        self._saving.note(snapshot)
        self._notices.compare(snapshot, views)


def solves(snapshot: Snapshot) -> list[float]:
    """What a plan has cost each robot of late [s]."""
    episode = snapshot.state.episode if snapshot.state is not None else None
    return [status.solve for status in snapshot.statuses.values() if status.episode == episode]


def _logo(ink: str) -> str:
    """The title as an image that needs no request."""
    svg = (
        '<svg xmlns="http://www.w3.org/2000/svg" width="480" height="40" viewBox="0 0 480 40">'
        '<g stroke="#56b4e9" stroke-width="2" fill="none"><path d="M8 32 L20 10 L32 32"/></g>'
        '<circle cx="20" cy="9" r="4.5" fill="#56b4e9"/><circle cx="8" cy="32" r="4.5" fill="#b284ff"/>'
        '<circle cx="32" cy="32" r="4.5" fill="#ff79c6"/>'
        f'<text x="46" y="29" font-family="sans-serif" font-size="23" font-weight="700" fill="{ink}">Echelon</text>'
        '<text x="166" y="28" font-family="sans-serif" font-size="15" fill="#8b94a5">'
        "formations that hold on broken links</text></svg>"
    )
    return "data:image/svg+xml;base64," + base64.b64encode(svg.encode()).decode()
