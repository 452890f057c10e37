"""Nodes of the scene: one for each kind of thing, never one per robot."""

from typing import Any

import numpy as np
import viser

from dashboard.scene import geometry
from dashboard.theme import colours
from formation.arrays import FloatArray


def lines(scene: viser.SceneApi, name: str, points: FloatArray, colour: FloatArray, thickness: float) -> Any:
    """Line segments (M, 2, 3) of one sRGB colour (3,), or of one for each end (M, 2, 3); thickness in pixels."""
    if colour.ndim == 1:
        colour = np.broadcast_to(colour, points.shape)
    return scene.add_line_segments(name, points, colours.encode(colour), thickness=thickness, thickness_units="screen")


def meshes(scene: viser.SceneApi, name: str, shape: tuple[FloatArray, geometry.Faces], count: int) -> Any:
    """So many flat things of one shape."""
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
