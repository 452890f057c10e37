"""Laws of the exported picture."""

import imageio.v3 as images
import numpy as np
import pytest

from dashboard.export.picture import as_png
from dashboard.theme.palette import DARK, LIGHT, Palette


@pytest.mark.parametrize("palette", [DARK, LIGHT], ids=["dark", "light"])
def test_what_is_transparent_shows_the_themes_background(palette: Palette) -> None:
    drawn = np.array([[[200, 100, 50, 0], [200, 100, 50, 255]]], dtype=np.uint8)
    transparent, opaque = images.imread(as_png(drawn, palette))[0]
    assert bytes(transparent[:3]).hex() == palette.background
    assert opaque[:3].tolist() == [200, 100, 50]
