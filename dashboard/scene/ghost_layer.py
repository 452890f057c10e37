"""The ghost in the scene: pale outlines of robots, a pale dashed pattern between them, pale dashed trails."""

from typing import Any

import numpy as np
import viser

from dashboard.scene import geometry, layers, nodes
from dashboard.telemetry.feed import Ghosts
from dashboard.telemetry.series import TRAIL_POINTS
from dashboard.theme import colours
from dashboard.theme.palette import Palette
from formation.arrays import FloatArray

PALE = 0.75
"""Share of the ghost's colour in its outlines; the rest is the background's."""


class GhostLayer:
    """The ghost's nodes; they exist from the start and are hidden while there is no ghost."""

    def __init__(self, scene: viser.SceneApi, robots: int, sizes: layers.Sizes, palette: Palette) -> None:
        """Make the nodes, hidden."""
        n, grey = robots, colours.rgb(palette.ghost)
        length, width = sizes.body
        self._sizes, self._shown = sizes, False
        self._allowed = True
        detail = sizes.detail
        outline = geometry.teardrop_rim(length, width, detail.corners, 0.0035 * sizes.unit)
        points = len(detail.points(TRAIL_POINTS))
        trail = layers.fading(np.tile(grey, (n, 1)), points, 0.6, palette, towards_end=False)
        edges = np.zeros((detail.pattern_dashes * n, 2, 3))
        self.nodes: dict[str, Any] = {
            "/ghosts": nodes.meshes(scene, "/ghosts", outline, n),
            "/ghost_edges": nodes.lines(scene, "/ghost_edges", edges, colours.mix(grey, 0.6, palette), 1.4),
            "/ghost_trails": nodes.lines(
                scene, "/ghost_trails", np.zeros((len(_every_other(trail, n)), 2, 3)), _every_other(trail, n), 1.6
            ),
        }
        self.nodes["/ghosts"].batched_colors = colours.encode(np.tile(colours.mix(grey, PALE, palette), (n, 1)))
        for node in self.nodes.values():
            node.visible = False

    def allow(self, allowed: bool) -> None:
        """Show the ghost if there is one, or hide it."""
        self._allowed = allowed

    def draw(self, track: Ghosts, stamp: float, *, trails: bool) -> None:
        """Bring it up to date; call within server.atomic().

        Args:
            track: the ghost's poses and trails.
            stamp: that of the robots as drawn [s].
            trails: whether the trails are drawn in this frame.
        """
        poses = track.poses(stamp) if self._allowed else None
        if (poses is not None) != self._shown:
            self._shown = poses is not None
            trails = True
            for node in self.nodes.values():
                node.visible = self._shown
        if poses is None:
            return
        z = self._sizes.z
        self.nodes["/ghosts"].batched_positions = geometry.lifted(poses[:, :2], z(8))
        self.nodes["/ghosts"].batched_wxyzs = geometry.turns(poses[:, 2])
        self.nodes["/ghost_edges"].points = layers.desired(poses, self._sizes.detail.pattern_dashes, z(4))
        if trails:
            segments = geometry.segments(self._sizes.detail.thinned(track.trail(poses)), z(2))
            self.nodes["/ghost_trails"].points = _every_other(segments, len(poses))


def _every_other(segments: FloatArray, robots: int) -> FloatArray:
    """Every other segment of polylines (n T, 2, 3): dashes."""
    per_robot = segments.reshape(robots, -1, 2, 3)[:, ::2]
    return per_robot.reshape(-1, 2, 3)
