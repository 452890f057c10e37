"""Laws of colours."""

import numpy as np

from dashboard.theme import colours
from dashboard.theme.palette import DARK, LIGHT


def test_the_tone_curve_gives_the_colours_that_were_asked_for() -> None:
    dark, light = ((p.ok, p.warn, p.bad, p.slot, p.background, p.identity[0]) for p in (DARK, LIGHT))
    for text in (*dark, *light, *LIGHT.identity):
        linear = colours.encode(colours.rgb(text)) / 255.0
        curve = (linear / 0.6) @ colours._INPUT.T
        curve = (curve * (curve + 0.0245786) - 0.000090537) / (curve * (0.983729 * curve + 0.4329510) + 0.238081)
        screen = np.clip(curve @ colours._OUTPUT.T, 0.0, 1.0)
        shown = np.where(screen <= 0.0031308, 12.92 * screen, 1.055 * screen ** (1 / 2.4) - 0.055)
        # The hue: a colour too bright for the curve comes out darker, one too pure a little paler.
        assert np.abs(shown - colours.rgb(text)).max() < 0.1, text
        if text in (DARK.background, LIGHT.background):
            assert np.abs(shown - colours.rgb(text)).max() < 0.005, "lines fade into it"
