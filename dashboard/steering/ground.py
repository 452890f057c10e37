"""Clicks on the ground, for whoever wants them: viser asks pages for clicks only while somebody does."""

import math
from collections.abc import Callable
from typing import NamedTuple

import viser

FARTHEST = 1e6
"""A click farther away is none on the ground [m]."""

Take = Callable[[int, float, float], None]
"""(page, x, y): a page clicked here, in the coordinates of what is drawn [m]."""


class _Taker(NamedTuple):
    wants: Callable[[int], bool]
    take: Take


class Ground:
    """Hands a click to the first who wants those of that page."""

    def __init__(self, server: viser.ViserServer) -> None:
        self._server = server
        self._takers: list[_Taker] = []
        self._listens = False
        self._on_click = self._clicked  # the very same object when it is removed

    def add(self, wants: Callable[[int], bool], take: Take) -> None:
        """Hand clicks to `take`, of pages that are wanted."""
        self._takers.append(_Taker(wants, take))

    def update(self) -> None:
        """Ask pages for clicks if one of them is wanted, else no more."""
        on = any(taker.wants(page) for page in self._server.get_clients() for taker in self._takers)
        if on and not self._listens:
            self._server.scene.on_click()(self._on_click)
        elif self._listens and not on:
            self._server.scene.remove_click_callback(self._on_click)
        self._listens = on

    def _clicked(self, event: viser.SceneClickEvent) -> None:
        (ox, oy, oz), (dx, dy, dz) = event.ray_origin, event.ray_direction
        if dz == 0.0:
            return
        x, y = ox - dx * oz / dz, oy - dy * oz / dz
        if not (math.isfinite(x) and math.isfinite(y) and max(abs(x), abs(y)) < FARTHEST):
            return
        for taker in self._takers:
            if taker.wants(event.client_id):
                taker.take(event.client_id, x, y)
                return
