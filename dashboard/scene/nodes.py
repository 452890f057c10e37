"""Nodes of the scene: one for each kind of thing, never one per robot."""

from typing import Any

import numpy as np
import viser

from dashboard.scene import geometry, layers
from dashboard.scene.path_line import path_dashes
from dashboard.telemetry.series import TRAIL_POINTS
from dashboard.theme import colours
from dashboard.theme.palette import Palette
from formation.arrays import FloatArray
from formation.scenario.scenario import Scenario

Shape = tuple[FloatArray, geometry.Faces]
"""Vertices and faces of a mesh."""


def lines(scene: viser.SceneApi, name: str, points: FloatArray, colour: FloatArray, thickness: float) -> Any:
    """Line segments (M, 2, 3) of one sRGB colour (3,), or of one for each end (M, 2, 3); thickness in pixels."""
    if colour.ndim == 1:
        colour = np.broadcast_to(colour, points.shape)
    return scene.add_line_segments(name, points, colours.encode(colour), thickness=thickness, thickness_units="screen")


def wide_line(scene: viser.SceneApi, name: str, steps: int, colour: FloatArray, width: float) -> Any:
    """A line of `steps` segments of one sRGB colour (3,), as wide as something in the scene [m]."""
    points = np.zeros((steps, 2, 3))
    encoded = colours.encode(np.broadcast_to(colour, points.shape))
    return scene.add_line_segments(name, points, encoded, thickness=width, thickness_units="world")


def meshes(scene: viser.SceneApi, name: str, shape: Shape, count: int) -> Any:
    """`count` flat meshes of one shape."""
    return scene.add_batched_meshes_simple(
        name,
        shape[0],
        shape[1],
        np.tile([1.0, 0.0, 0.0, 0.0], (count, 1)),
        np.zeros((count, 3)),
        batched_colors=np.zeros((count, 3), dtype=np.uint8),
        lod="off",
        side="double",
        cast_shadow=False,
        receive_shadow=False,
    )


def scenario_nodes(scene: viser.SceneApi, scenario: Scenario, sizes: layers.Sizes, palette: Palette) -> dict[str, Any]:
    """All nodes of a scenario but the ghost's, by name.

    Positions and colours are set with every frame; what is set here is their number, and what never changes.

    Args:
        scene: of viser.
        scenario: that is shown.
        sizes: of its robots.
        palette: of the theme.
    """
    n, steps = scenario.size, scenario.controller.horizon
    hue, unit, detail = colours.identities(n, palette), sizes.unit, sizes.detail
    dashes, corners = detail.dashes, detail.corners
    length, width = sizes.body
    path = geometry.lifted(path_dashes(scenario), sizes.z(1))
    trail = layers.fading(hue, len(detail.points(TRAIL_POINTS)), 0.85, palette, towards_end=False)
    planned = len(detail.points(steps + 1))
    horizon = layers.fading(hue, planned, 1.0, palette, towards_end=True)
    belief = np.repeat(np.repeat(colours.mix(hue, 0.85, palette)[:, None], planned // 2, axis=0), 2, axis=1)
    desired = colours.rgb(palette.desired)

    def segments(name: str, count: int, colour: FloatArray, thickness: float) -> Any:
        return lines(scene, name, np.zeros((count, 2, 3)), colour, thickness)

    made = {
        "/path": lines(scene, "/path", path, colours.rgb(palette.path), 1.4),
        "/trails": segments("/trails", len(trail), trail, 2.0),
        "/slots": meshes(scene, "/slots", geometry.ring(0.025 * unit, 0.0022 * unit, corners), n),
        "/desired": segments("/desired", detail.pattern_dashes * n, desired, 1.2),
        "/beliefs": segments("/beliefs", len(belief), belief, 1.8),
        "/horizons": segments("/horizons", len(horizon), horizon, 2.6),
        "/edges": segments("/edges", n, np.zeros(3), 3.2),
        "/links": segments("/links", n * dashes, np.zeros(3), 1.8),
        "/heads": meshes(scene, "/heads", geometry.arrow_head(0.016 * unit, 0.012 * unit), n),
        "/outlines": meshes(scene, "/outlines", geometry.teardrop(length, width, corners, 0.003 * unit), n),
        "/bodies": meshes(scene, "/bodies", geometry.teardrop(length, width, corners), n),
        "/off": segments("/off", n * dashes, colours.rgb(palette.bad), 1.8),
        "/believed": meshes(scene, "/believed", geometry.teardrop_rim(length, width, corners, 0.0032 * unit), n),
    }
    if scenario.path.known_to == "leader":
        made["/preview"] = segments("/preview", steps, colours.mix(hue[0], 0.6, palette), 6.0)
        if scenario.driven:
            made["/preview"] = wide_line(scene, "/preview", steps, colours.mix(hue[0], 0.35, palette), sizes.ribbon)
            count = 2 * steps + steps // layers.TICK
            made["/ribbon"] = segments("/ribbon", count, colours.mix(hue[0], 0.85, palette), 1.6)
        made["/goal"] = segments("/goal", 2, hue[0], 2.6)
        made["/told"] = meshes(scene, "/told", geometry.ring(0.008 * unit, 0.0028 * unit, corners), n)
        made["/told"].batched_colors = colours.encode(np.tile(hue[0], (n, 1)))
    made["/believed"].batched_colors = colours.encode(hue)
    made["/slots"].batched_colors = colours.encode(np.tile(colours.rgb(palette.slot), (n, 1)))
    return made
