"""The robots' numbers as lines: a page shows them over the scene, but a picture of the view needs them in it."""

import numpy as np

from dashboard.scene import geometry, layers
from formation.arrays import FloatArray

HEIGHT = 0.017
"""Of a number, for robots 0.1 m apart [m]."""


def number_lines(poses: FloatArray, sizes: layers.Sizes) -> FloatArray:
    """Line segments (M, 2, 3) of the numbers of robots at poses (n, 3) [m]."""
    strokes = [geometry.digits(i, HEIGHT * sizes.unit) + pose[:2] for i, pose in enumerate(poses, start=1)]
    return geometry.lifted(np.concatenate(strokes), sizes.z(11))
