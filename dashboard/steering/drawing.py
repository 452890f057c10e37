"""The folder in which a path is drawn by clicking points on the ground, saved as a scenario file, or run at once.

There is one drawing for all pages; the page that pressed Draw last adds the points.
"""

from typing import Any, NamedTuple

import numpy as np
import viser

from dashboard.edits import on_edit
from dashboard.notices import Notify
from dashboard.panels.mirrored_controls import set_if_changed
from dashboard.requests import RequestQueue
from dashboard.scenario_list import use_table
from dashboard.scene import geometry
from dashboard.telemetry.snapshot import Snapshot
from dashboard.theme.templates import render
from formation.arrays import FloatArray
from formation.errors import ScenarioError
from formation.paths.waypoints import Waypoints
from formation.scenario.files import parse
from formation.scenario.scenario import Scenario
from formation.scenario.toml_text import as_toml

MOST = 200
"""Points of a drawing."""
NAME = "drawn"
"""Of the scenario, and of its file."""
SAMPLES = 300
"""Of the curve as it is shown."""
CROSS = 0.006
"""Half of a cross at a point, for a spacing of 0.1 m [m]."""
NODE, COLOUR, HEIGHT = "/drawing", (86, 180, 233), 0.004
DRAW, UNDO, SAVE, RUN = "Draw", "Undo", "Save", "Run it"


class Drawn(NamedTuple):
    """What points make: a scenario with that path, or why not."""

    scenario: Scenario | None
    reason: str = ""

    @property
    def path(self) -> Waypoints | None:
        """The path, if there is a scenario."""
        path = self.scenario.path if self.scenario else None
        return path if isinstance(path, Waypoints) else None


def drawn(scenario: Scenario, points: list[tuple[float, float]], *, closed: bool) -> Drawn:
    """The scenario with a path through these points [m], in its own coordinates, in place of its path."""
    table = scenario.model_dump(mode="json", exclude_unset=True)
    speed = float(getattr(scenario.path, "speed", 0.1))
    path: dict[str, Any] = {
        "kind": "waypoints",
        "points": [[round(x, 3), round(y, 3)] for x, y in points],
        "speed": speed,
        "closed": closed,
        "known_to": scenario.path.known_to,
    }
    table |= {"name": NAME, "source": f"drawn on the page, over {scenario.name}", "path": path}
    table.get("robots", {}).pop("poses", None)  # they start on the new path
    try:
        course = Waypoints.model_validate(path).course
        table["duration"] = round(max(1.0, course.travel.length / speed), 1)
        return Drawn(parse(table, where=NAME))
    except ScenarioError as error:
        return Drawn(None, str(error).splitlines()[0])
    except ValueError:
        return Drawn(None, f"A path wants {3 if closed else 2} points that differ; there are {len(points)}.")


class DrawPanel:
    """The drawing and its controls, in the current container of the page."""

    def __init__(self, server: viser.ViserServer, requests: RequestQueue, notify: Notify) -> None:
        """Add the folder.

        Args:
            server: of the page.
            requests: to the world.
            notify: shows why something was not done.
        """
        self._server, self._requests, self._notify = server, requests, notify
        self._points: list[tuple[float, float]] = []
        """In the coordinates of the scenario [m]."""
        self._page: int | None = None
        """Whose clicks are points."""
        self._scenario: Scenario | None = None
        self._origin = np.zeros(2)
        self._drawn: tuple[object, Drawn] = (None, Drawn(None))
        self._line: Any = None
        self._line_key: object = None
        gui = server.gui
        with gui.add_folder("Draw a path", expand_by_default=False, visible=requests.possible):
            self._shown = gui.add_html("")
            first = gui.add_button_group("Points", (DRAW, UNDO), hint="Draw again: no more; Undo: not the last")
            self._closed: Any = gui.add_checkbox("Closed", True, hint="The path returns to its first point")
            second = gui.add_button_group(
                "Path", (SAVE, RUN), hint="This scenario with that path: a file for `echelon up FILE`, or now"
            )
        on_edit(first, lambda edit: self._place(edit.value, edit.page))
        on_edit(second, lambda edit: self._use(edit.value, edit.client), slow=True)
        server.on_client_disconnect(self._gone)

    def _gone(self, client: viser.ClientHandle) -> None:
        if self._page == client.client_id:
            self._page = None

    # ------------------------------------------------------------------ from the user

    def wants(self, page: int) -> bool:
        """Whether clicks on the ground of this page are points."""
        return page == self._page

    def add(self, page: int, x: float, y: float) -> None:
        """A page clicked here: the next point [m]."""
        if len(self._points) >= MOST:
            self._notify(page, "Not drawn", f"A drawing has at most {MOST} points.")
            return
        east, north = self._origin.tolist()
        self._points = [*self._points, (x + east, y + north)]

    def _place(self, button: str, page: int) -> None:
        if button == DRAW:
            self._page = None if self._page == page else page
        else:
            self._points = self._points[:-1]

    def _use(self, button: str, client: viser.ClientHandle) -> None:
        found, page = self._made(), client.client_id
        if found.scenario is None:
            self._notify(page, "Not done", found.reason)
        elif button == SAVE:
            client.send_file_download(f"{NAME}.toml", as_toml(found.scenario).encode(), save_immediately=True)
        else:
            self._page = None
            self._requests.ask(use_table(found.scenario), page)

    def _made(self) -> Drawn:
        """What the points make; worked out once for the same points."""
        scenario = self._scenario
        if scenario is None:
            return Drawn(None, "There is no run yet.")
        key = (scenario, self._points, self._closed.value)
        if self._drawn[0] != key:
            self._drawn = key, drawn(scenario, self._points, closed=bool(self._closed.value))
        return self._drawn[1]

    # ------------------------------------------------------------------ to the page

    def draw(self, snapshot: Snapshot) -> None:
        """Show the drawing."""
        if snapshot.scenario is None:
            return
        self._scenario, self._origin = snapshot.scenario, snapshot.origin
        path = self._made().path if len(self._points) > 1 else None
        length = path.course.travel.length if path else 0.0
        values = {"points": len(self._points), "length": length, "page": self._page}
        speed = path.speed if path else 1.0
        set_if_changed(
            self._shown, "content", render("steering/drawing.html", **values, speed=speed, seconds=length / speed)
        )
        key = (self._points, self._closed.value, tuple(self._origin.tolist()))
        if key != self._line_key:
            self._line_key = key
            self._show(path)

    def _show(self, path: Waypoints | None) -> None:
        if self._line is not None:
            self._line.remove()
            self._line = None
        if not self._points:
            return
        lines = [_crosses(np.array(self._points) - self._origin)]
        if path is not None:
            curve = path.course.travel(np.linspace(0.0, path.course.travel.length, SAMPLES)) - self._origin
            lines.append(geometry.segments(curve[None], HEIGHT))
        self._line = self._server.scene.add_line_segments(
            NODE, np.concatenate(lines), COLOUR, thickness=2.4, thickness_units="screen"
        )


def _crosses(points: FloatArray) -> FloatArray:
    """(2 M, 2, 3): a cross at each of the points (M, 2) [m]."""
    arms = CROSS * np.array([[[-1.0, -1.0], [1.0, 1.0]], [[-1.0, 1.0], [1.0, -1.0]]])
    return geometry.lifted((points[:, None, None] + arms).reshape(-1, 2, 2), HEIGHT)
