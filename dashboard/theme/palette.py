"""The two themes of the page: dark and light. Hue identifies a robot; green, amber and red are health only.

The panels are HTML and take their colours from variables of the style sheet, of which the page picks the theme. The
scene is drawn by this process, so that all pages share its theme.
"""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Palette:
    """Colours "rrggbb" of one theme."""

    dark: bool
    identity: tuple[str, ...]
    """Hues of robots 1 to 8, none of them green, amber or red."""
    crowd: str
    """Body colour when there are too many robots for a hue each."""
    ok: str
    warn: str
    bad: str
    muted: str
    """Small print."""
    background: str
    """Behind the scene; lines fade into it."""
    ghost: str
    """Robots and curves of the ghost."""
    slot: str
    path: str
    desired: str
    outline: str
    """Outline of a body."""
    chosen: str
    """Outline of the chosen robot's body."""
    number: str
    """Number on a body."""
    cell: str
    section: str
    """Fine and coarse lines of the ground."""
    ink: str
    """Text over the scene."""
    veil: str
    """Behind such text, with its opacity."""

    def named(self) -> dict[str, str]:
        """The colours that HTML and plots use, by the name of their style sheet variable: ok, r1, ..."""
        hues = {f"r{i}": hue for i, hue in enumerate(self.identity, start=1)}
        names = ("ok", "warn", "bad", "muted", "crowd", "ghost", "background", "number", "ink", "veil")
        return {**{name: getattr(self, name) for name in names}, **hues}


DARK = Palette(
    dark=True,
    identity=("56b4e9", "b284ff", "ff79c6", "40d6d6", "ececec", "7f9cff", "d9b8ff", "9fc3d6"),
    crowd="9fb4cc",
    ok="34c796",
    warn="f7b83e",
    bad="f0485c",
    muted="8b94a5",
    background="141414",
    ghost="aab2c0",
    slot="566170",
    path="8892a6",
    desired="6b7688",
    outline="0c0f13",
    chosen="ffffff",
    number="0a0d11",
    cell="34363e",
    section="424a60",
    ink="e6eaf0",
    veil="1e2025db",
)
LIGHT = Palette(
    dark=False,
    identity=("1f7fc4", "7a4fd0", "cf2f8b", "0d8a8f", "434b58", "3f5bd0", "9a62cf", "56798c"),
    crowd="5c7390",
    ok="0e8f66",
    warn="b86e00",
    bad="d11f3a",
    muted="5f6878",
    background="d9dde2",
    ghost="5f6878",
    slot="9aa3b0",
    path="6f7989",
    desired="8b95a4",
    outline="f2f4f6",
    chosen="10151c",
    number="ffffff",
    cell="cfd4db",
    section="b9c1cc",
    ink="1b222c",
    veil="f4f6f8e0",
)


def hue(robot: int, robots: int) -> str:
    """A robot's colour in HTML."""
    return f"var(--r{robot})" if robots <= len(DARK.identity) else "var(--crowd)"
