"""The folders Drive and Draw a path, which share the clicks on the ground."""

import viser

from dashboard.notices import Notify
from dashboard.requests import RequestQueue
from dashboard.steering.drawing import DrawPanel
from dashboard.steering.driving import DrivePanel
from dashboard.steering.ground import Ground
from dashboard.telemetry.snapshot import Snapshot


class Steering:
    """Both folders, in the current container of the page."""

    def __init__(self, server: viser.ViserServer, requests: RequestQueue, notify: Notify) -> None:
        self._driving = DrivePanel(server, requests)
        self._drawing = DrawPanel(server, requests, notify)
        self._ground = Ground(server)
        self._ground.add(self._drawing.wants, self._drawing.add)  # who draws does not drive by the same click
        self._ground.add(self._driving.wants, self._driving.go)

    def draw(self, snapshot: Snapshot) -> None:
        """Show the run as it is."""
        self._driving.draw(snapshot)
        self._drawing.draw(snapshot)
        self._ground.update()
