"""The right panel: what is so, in tabs. What no page has open is drawn now and then only."""

from collections.abc import Collection, Iterable
from time import monotonic
from typing import Any

import viser

from dashboard.panels.clickable import Clickable
from dashboard.panels.event_log import event_log
from dashboard.panels.ledger import LedgerTab
from dashboard.panels.link_matrix import link_matrix
from dashboard.panels.network import NetworkTab
from dashboard.panels.plots import BELIEF, FIRST, SECOND, Chart
from dashboard.panels.robot_table import robot_table
from dashboard.telemetry.feed import Feed, View
from dashboard.theme.palette import Palette

HIDDEN_SECONDS = 3.0
"""Between two drawings of a tab that no page has open [s]."""
LIVE, ROBOTS, NETWORK, LEDGER, LOG = NAMES = "Live", "Robots", "Network", "Ledger", "Log"


class Tabs:
    """The tabs, and which of them the pages have open."""

    def __init__(self, gui: viser.GuiApi, feed: Feed) -> None:
        """Add the panel to the page."""
        self._feed = feed
        self.ledger, self._network = LedgerTab(feed.playhead), NetworkTab(feed)
        self._open: dict[int, frozenset[str]] = {}
        """By page, what it has told."""
        self._drawn_at: dict[tuple[str, str], float] = {}
        """By tab and part of it."""
        self._panel = panel = gui.add_panel()
        with panel.add_tab(LIVE):  # five tabs fit in a row without icons only
            first = [Chart(gui, plot) for plot in FIRST]
            self._link_matrix: Any = gui.add_html("")
            charts = [*first, *(Chart(gui, plot) for plot in SECOND)]
        with panel.add_tab(ROBOTS):
            self._robot_table: Any = gui.add_html("")
        with panel.add_tab(NETWORK):
            self._network_cards: Any = gui.add_html("")
            belief = Chart(gui, BELIEF)
        with panel.add_tab(LEDGER):
            self._ledger_table: Any = gui.add_html("")
        with panel.add_tab(LOG):
            self._event_log: Any = gui.add_html("")
        panel.dock_right()
        self._charts = {LIVE: charts, NETWORK: [belief]}

    def set_width(self, width: int) -> None:
        """Of the panel, in all pages [px]."""
        self._panel.set_width(width)

    def set_palette(self, palette: Palette) -> None:
        """Draw in another theme from now on."""
        for charts in self._charts.values():
            for chart in charts:
                chart.set_palette(palette)

    # ------------------------------------------------------------------ what pages have open

    def tell(self, page: int, names: Iterable[str]) -> None:
        """A page has these tabs open, it says; a panel can be taken apart, so that there are several."""
        self._open[page] = frozenset(names) & frozenset(NAMES)

    def forget(self, page: int) -> None:
        """A page is gone."""
        self._open.pop(page, None)

    def seen(self, pages: Collection[int]) -> frozenset[str]:
        """The tabs that any of these pages has open; one that has told nothing yet may have any."""
        told = [self._open.get(page) for page in pages]  # a page may go, or tell something, meanwhile
        return frozenset(NAMES) if None in told else frozenset(name for names in told if names for name in names)

    # ------------------------------------------------------------------ drawing

    def draw(
        self, live: View, view: View, clickable: Clickable, target: Collection[str], seen: Collection[str]
    ) -> None:
        """Draw the tables and cards of a moment.

        Args:
            live: the run as it is.
            view: the moment that is looked at.
            clickable: for the cells.
            target: names of the links that are chosen.
            seen: names of the tabs that are seen.
        """
        if self._due(LIVE, seen):
            self._link_matrix.content = link_matrix(view.snapshot, view.links, clickable, target)
        if self._due(ROBOTS, seen):
            self._robot_table.content = robot_table(view.snapshot, view.links, clickable)
        if self._due(NETWORK, seen):
            self._network_cards.content = self._network.html(view, clickable, target)
        if self._due(LEDGER, seen):
            self._ledger_table.content = self.ledger.html(live.snapshot, clickable)
        if self._due(LOG, seen):
            self._event_log.content = event_log(view.snapshot.state)

    def draw_plots(self, view: View, seen: Collection[str]) -> None:
        """Draw the plots around the moment that is looked at."""
        due = [chart for tab, charts in self._charts.items() if self._due(tab, seen, "plots") for chart in charts]
        if not due:
            return
        series, state = self._feed.series(view), view.snapshot.state
        cursor, spans = (None if view.place is None else view.place.stamp), self._feed.spans(view)
        for chart in due:
            chart.draw(series, ghost=bool(state and state.compare), cursor=cursor, spans=spans, chosen=self.ledger.span)

    def _due(self, tab: str, seen: Collection[str], part: str = "tables") -> bool:
        """Whether to draw a part of a tab: if that is seen, or the part has not been drawn for HIDDEN_SECONDS."""
        now = monotonic()
        if tab not in seen and now - self._drawn_at.get((tab, part), 0.0) < HIDDEN_SECONDS:
            return False
        self._drawn_at[tab, part] = now
        return True
