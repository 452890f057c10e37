"""The view as a PNG."""

from typing import Any

import imageio.v3 as images
import numpy as np

from dashboard.theme.palette import Palette


def as_png(drawn: np.ndarray[Any, np.dtype[np.uint8]], palette: Palette) -> bytes:
    """The view (height, width, 4) as a page has drawn it, on the theme's background."""
    share = drawn[..., 3:] / 255.0
    background = np.array([int(palette.background[i : i + 2], 16) for i in (0, 2, 4)])
    flat = drawn[..., :3] * share + background * (1.0 - share)
    return bytes(images.imwrite("<bytes>", flat.round().astype(np.uint8), extension=".png"))
