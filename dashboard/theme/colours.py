"""Colours as numbers: given as sRGB, encoded for viser's renderer.

The page's canvas is tone-mapped (ACES, as in three.js), and colours per vertex or per instance are taken as linear.
`encode` inverts both, so that the screen shows the colour that was asked for.
"""

import numpy as np

from dashboard.theme.palette import DARK, LIGHT, Palette
from formation.arrays import FloatArray

Bytes = np.ndarray[tuple[int, ...], np.dtype[np.uint8]]

_INPUT = np.array([[0.59719, 0.35458, 0.04823], [0.07600, 0.90834, 0.01566], [0.02840, 0.13383, 0.83777]])
_OUTPUT = np.array([[1.60475, -0.53108, -0.07367], [-0.10208, 1.10813, -0.00605], [-0.00327, -0.07276, 1.07602]])
"""three.js, ACESFilmicToneMapping: sRGB to the curve's space and back."""
_FROM_INPUT, _FROM_OUTPUT = np.linalg.inv(_INPUT).T, np.linalg.inv(_OUTPUT).T


def rgb(text: str) -> FloatArray:
    """(3,) sRGB in 0..1 of a colour "rrggbb"."""
    return np.array([int(text[i : i + 2], 16) / 255.0 for i in (0, 2, 4)])


def identity(robot: int, robots: int, palette: Palette = DARK) -> str:
    """The colour "rrggbb" of a robot."""
    return palette.identity[robot - 1] if robots <= len(palette.identity) else palette.crowd


def identities(robots: int, palette: Palette) -> FloatArray:
    """(n, 3) sRGB colours of all robots."""
    return np.array([rgb(identity(i, robots, palette)) for i in range(1, robots + 1)])


def health(level: FloatArray, palette: Palette = DARK) -> FloatArray:
    """(..., 3) sRGB from green (0) over amber (0.5) to red (1)."""
    stops = np.array([rgb(palette.ok), rgb(palette.warn), rgb(palette.bad)])
    return np.stack([np.interp(level, [0.0, 0.5, 1.0], stops[:, c]) for c in range(3)], axis=-1)


def css(colour: FloatArray) -> str:
    """The colour as CSS writes it: "#rrggbb"."""
    r, g, b = (round(255 * float(c)) for c in np.clip(colour, 0.0, 1.0))
    return f"#{r:02x}{g:02x}{b:02x}"


def mix(colour: FloatArray, share: FloatArray | float, palette: Palette) -> FloatArray:
    """`colour` where `share` is 1, the background where it is 0."""
    background = rgb(palette.background)
    return np.asarray(background + (colour - background) * share)


def encode(colour: FloatArray) -> Bytes:
    """(..., 3) bytes for per-instance and per-vertex colours that look like this sRGB colour.

    A colour too bright for the tone curve is darkened until it fits, so that its hue is kept.
    """
    screen = np.where(colour <= 0.04045, colour / 12.92, ((colour + 0.055) / 1.055) ** 2.4)
    low, high = np.zeros(screen.shape[:-1]), np.ones(screen.shape[:-1])
    fits = _untoned(screen).max(axis=-1) <= 1.0
    for _ in range(8):  # bisection for the brightness
        middle = (low + high) / 2.0
        inside = _untoned(screen * middle[..., None]).max(axis=-1) <= 1.0
        low, high = np.where(inside, middle, low), np.where(inside, high, middle)
    linear = _untoned(screen * np.where(fits, 1.0, low)[..., None])
    return np.asarray(np.round(255.0 * np.clip(linear, 0.0, 1.0)), dtype=np.uint8)


def _untoned(screen: FloatArray) -> FloatArray:
    """Linear colours before tone mapping that give these linear colours after it."""
    fitted = np.clip(screen @ _FROM_OUTPUT, 0.0, 0.98)
    # Solve fitted = (v (v + 0.0245786) - 0.000090537) / (v (0.983729 v + 0.4329510) + 0.238081) for v.
    a = 1.0 - 0.983729 * fitted
    b = 0.0245786 - 0.4329510 * fitted
    c = -0.000090537 - 0.238081 * fitted
    curve = (-b + np.sqrt(np.maximum(b * b - 4.0 * a * c, 0.0))) / (2.0 * a)
    return np.asarray(0.6 * (curve @ _FROM_INPUT))


_RAMPS = {palette: encode(health(np.linspace(0.0, 1.0, 256), palette)) for palette in (DARK, LIGHT)}


def encoded_health(level: FloatArray, palette: Palette) -> Bytes:
    """(..., 3) bytes of `health`, from a table: it is called ten times a second."""
    return _RAMPS[palette][np.asarray(255.0 * np.clip(level, 0.0, 1.0), dtype=np.uint8)]


_CSS_HEALTH = tuple(css(colour) for colour in health(np.linspace(0.0, 1.0, 64)))


def css_health(level: float) -> str:
    """CSS colour of a level from 0 to 1 in the dark theme, from a table."""
    return _CSS_HEALTH[int(63 * level)]
