"""The page as a whole: where its panels are, and the loop that keeps them up to date."""

import gc
from collections.abc import Collection
from time import monotonic, sleep
from typing import Any

import viser

from dashboard.notices import Notice, Notices
from dashboard.overlay.overlay import Overlay
from dashboard.overlay.time_line import TimeLine
from dashboard.pacing import UNWATCHED_FRAME, UNWATCHED_PAUSE, pace
from dashboard.panels.agent_lifecycle import VERBS, AgentLifecycle
from dashboard.panels.clickable import Clickable
from dashboard.panels.export import ExportButtons
from dashboard.panels.faults import FaultPanel
from dashboard.panels.ledger import VERB as LEDGER
from dashboard.panels.push import PushPanel
from dashboard.panels.record import RecordPanel
from dashboard.panels.run import RunPanel
from dashboard.panels.tabs import NAMES, Tabs
from dashboard.panels.view import ViewPanel
from dashboard.requests import NO_RUN, RequestQueue
from dashboard.scenario_list import ScenarioList
from dashboard.scene.cameras import Cameras
from dashboard.scene.scene import Scene
from dashboard.steering.steering import Steering
from dashboard.telemetry.feed import Feed, View
from dashboard.telemetry.snapshot import Snapshot
from dashboard.telemetry.subscriber import TelemetrySubscriber
from dashboard.theme.palette import DARK, Palette
from dashboard.theme.templates import style_element
from dashboard.theme.titlebar import apply_theme
from network.bus import Bus
from network.lifetime import Lifetime
from network.throttled_log import ThrottledLog

WIDE = 1400
"""Pages that are narrower than this get narrower panels [px]."""
COLLECT_SECONDS = 1.0
"""Between two collections of what pages that are gone have left: viser's objects of a page refer to each other [s]."""
PANEL_WIDTHS = {True: (330, 400), False: (296, 320)}
"""Of the left and the right panel, for wide pages and for others [px]; they are the same for all pages."""


class Page:
    """The panels and the scene, and the telemetry they are drawn from."""

    def __init__(
        self,
        server: viser.ViserServer,
        bus: Bus | None,
        scenarios: ScenarioList | None = None,
        feed: Feed | None = None,
        name: str = "",
    ) -> None:
        """Add everything to the page.

        Args:
            server: of the page.
            bus: of the run; None for a record.
            scenarios: what the page offers; the shipped ones, if absent.
            feed: of what is shown; that of the run, if absent.
            name: of the record.
        """
        self._server = server
        self._scenarios = scenarios or ScenarioList()
        if feed is None:
            assert bus is not None
            feed = Feed(TelemetrySubscriber(bus))
        self._feed = feed
        self._widths: dict[int, int] = {}
        """Of the pages' windows [px]."""
        self._wide = True
        self._left_behind, self._collected_at = False, 0.0
        """Whether pages have gone since the last collection."""
        self._overlay: Overlay | None = None
        self._notices = Notices(self._show_notice)
        self._requests = RequestQueue(bus, self._feed.source, self._notices.notify)
        self._agent_lifecycle = AgentLifecycle(self._requests)
        self._cameras = Cameras(server)
        self._scene = Scene(server, on_robot=self._robot_clicked, on_link=self._link_clicked, on_drag=self._dragged)
        self._errors = ThrottledLog()
        self._panels_drawn_at = self._plots_drawn_at = 0.0
        self._panels_key: tuple[object, ...] = ()
        """Of the panels as last drawn: they are drawn at once when it changes."""
        self._palette = DARK
        apply_theme(server.gui, self._palette)
        self._add_left_panel(server.gui, name if bus is None else bus.run)
        self._tabs = Tabs(server.gui, self._feed)
        self._set_widths()

    def _add_left_panel(self, gui: viser.GuiApi, run: str) -> None:
        gui.add_html(style_element())
        self._run = RunPanel(gui, self._requests, self._scenarios, self._feed)
        self._steering = Steering(self._server, self._requests, self._notices.notify)
        self._push = PushPanel(gui, self._requests)
        self._faults = FaultPanel(gui, self._requests)
        self._view = ViewPanel(gui, self._cameras, self._scene, self._set_palette)
        self._export = ExportButtons(gui, run, self._feed.export_buffer, lambda: self._palette, self._notices.notify)
        self._record = RecordPanel(gui, self._requests)
        self._clickable = Clickable(gui, self._clicked)
        self._overlay = Overlay(self._server, self._told)
        self._time_line = TimeLine(gui, self._feed)
        gui.main_panel.dock_left()
        self._server.on_client_disconnect(self._closed)

    def _set_widths(self) -> None:
        """Of both panels, by the narrowest page."""
        left, right = PANEL_WIDTHS[self._wide]
        self._server.gui.main_panel.set_width(left)
        self._tabs.set_width(right)

    def _show_notice(self, page: int | None, notice: Notice) -> None:
        if self._overlay is not None:
            self._overlay.notify(page, notice)

    # ------------------------------------------------------------------ from the user

    def _set_palette(self, palette: Palette) -> None:
        self._palette = palette  # the scene takes it over with the next frame
        apply_theme(self._server.gui, palette)
        self._tabs.set_palette(palette)

    def _robot_clicked(self, client: viser.ClientHandle, robot: int) -> None:
        self._view.focus_on(client, robot)
        self._push.choose(robot)

    def _dragged(self, robot: int, event: viser.SceneNodeDragEvent[Any]) -> None:
        self._push.dragged(robot, event)

    def _link_clicked(self, sender: int) -> None:
        self._faults.choose("link", sender)

    def _clicked(self, verb: str, number: int, client: viser.ClientHandle) -> None:
        """A user clicked a cell of a table."""
        if verb == "focus":
            self._view.focus_on(client, number)
        elif verb in VERBS and not self._requests.possible:
            self._requests.refuse(*NO_RUN, client.client_id)
        elif verb == LEDGER:
            self._tabs.ledger.press(number)
        elif verb in VERBS:
            self._agent_lifecycle.clicked(verb, number, client)
        else:
            self._faults.choose(verb, number)

    def _closed(self, client: viser.ClientHandle) -> None:
        """A page is gone."""
        self._widths.pop(client.client_id, None)
        self._tabs.forget(client.client_id)
        self._left_behind = True

    def _told(self, page: int, words: list[str]) -> None:
        """A page's script tells something; it may be anything."""
        match words:
            case ["width", text] if text.isascii() and text.isdigit():
                self._widths[page] = int(text)
                wide = min(self._widths.values()) >= WIDE
                if wide != self._wide:
                    self._wide = wide
                    self._set_widths()
            case ["tabs", *names]:
                self._tabs.tell(page, names)
            case _:
                self._feed.playhead.tell(words)

    # ------------------------------------------------------------------ the loop

    def serve(self, lifetime: Lifetime) -> None:
        """Keep the page up to date until the lifetime is over; a frame that raises is logged and left out."""
        gc.collect()
        gc.freeze()  # what there is now stays: a collection need not look at it again
        self._feed.source.start()
        self._requests.start()
        due, robots = monotonic(), 0
        while not lifetime.over:
            try:
                robots = self._frame() if self._due else len(self._feed.now().snapshot.poses)
            except Exception:
                self._errors.add_exception("drawing a frame")
            self._collect()
            due = max(due + self._pause(robots), monotonic())
            sleep(max(0.0, due - monotonic()))
        self._requests.stop()
        self._feed.source.stop()

    def _collect(self) -> None:
        """Free what pages that are gone have left; Python by itself would look for it only after many more."""
        if self._left_behind and monotonic() - self._collected_at >= COLLECT_SECONDS:
            self._left_behind = False
            gc.collect()
            self._collected_at = monotonic()

    @property
    def _watched(self) -> bool:
        return bool(self._server.get_clients())

    @property
    def _due(self) -> bool:
        """Whether to draw now."""
        return self._watched or monotonic() - self._panels_drawn_at >= UNWATCHED_FRAME

    def _pause(self, robots: int) -> float:
        """From this frame to the next [s]."""
        if not self._watched:
            return 0.0 if self._feed.loading else UNWATCHED_PAUSE
        return pace(robots).frame

    def _frame(self) -> int:
        """Draw once; returns the number of robots."""
        live, whole = self._feed.now(), not self._watched
        view = self._feed.shown(live)
        snapshot = view.snapshot
        state = snapshot.state
        with self._server.atomic():
            self._scene.set_palette(self._palette)
            self._scene.draw(view, whole=whole)
            seen = self._tabs.seen(self._server.get_clients())
            now, key, rate = monotonic(), self._key(live, view, seen), pace(len(snapshot.poses))
            panels = now - self._panels_drawn_at >= rate.panels or key != self._panels_key
            if panels:
                self._draw_panels(live, view, NAMES if whole or key != self._panels_key else seen)
                self._panels_drawn_at, self._panels_key = now, key
            if whole or (not panels and now - self._plots_drawn_at >= rate.plots):
                self._plots_drawn_at = now
                self._tabs.draw_plots(view, NAMES if whole else seen)
        if state is not None and snapshot.scenario is not None and len(snapshot.poses) == snapshot.scenario.size:
            self._cameras.update(snapshot.scenario, snapshot.poses, state.live)
        return len(snapshot.poses)

    def _key(self, live: View, view: View, seen: Collection[str]) -> tuple[object, ...]:
        """What users see at once when it changes; the rest of the panels is drawn now and then (pacing.py)."""
        snapshot, state = live.snapshot, live.snapshot.state
        place = None if view.place is None or self._feed.playhead.playing else view.place
        page = (snapshot.world_alive, snapshot.connected, self._faults.target, self._scene.focus, place, seen)
        if state is None:
            return page
        newest = state.events[-1].number if state.events else 0
        run = (state.episode, state.revision, state.status, state.speed, state.compare, newest)
        return (*page, *run, tuple(state.dismissed), tuple(state.live))

    def _draw_panels(self, live: View, view: View, seen: Collection[str]) -> None:
        """Draw what belongs to the moment that is looked at, and controls as the run has them now."""
        snapshot = live.snapshot
        self._run.draw(live, view)
        self._steering.draw(snapshot)
        n = len(snapshot.poses)
        driver = {"driver": 1} if _driven(snapshot) else {}
        verbs = {"all": 0, **driver, **dict.fromkeys(("link", "both", "focus", *VERBS), n)}
        self._clickable.set_verbs({**verbs, **self._tabs.ledger.verbs(snapshot.state)} if n else {})
        self._tabs.draw(live, view, self._clickable, self._faults.target, seen)
        if snapshot.state is not None:
            self._faults.draw(snapshot.state, driven=_driven(snapshot))
            self._push.draw(snapshot)
            self._agent_lifecycle.draw(snapshot.state)
            self._view.draw(snapshot.state)
            self._record.draw(snapshot.state)
        self._export.update(snapshot)
        if self._overlay is not None:
            self._overlay.draw(view, self._scene.sizes)
        self._time_line.draw(live, view)
        self._notices.update(snapshot, live.links)


def _driven(snapshot: Snapshot) -> bool:
    return snapshot.scenario is not None and snapshot.scenario.driven
