"""viser's icons, from its archive opened once: viser reads the archive's four thousand names again for every icon."""

from functools import cache
from zipfile import ZipFile

from viser import _gui_api, _gui_handles, _icons

NAME = "svg_from_icon"
"""Of viser's function."""


def open_once() -> None:
    """Have viser take its icons from here."""
    for module in (_gui_api, _gui_handles):  # each looks the name up for every icon
        setattr(module, NAME, svg)


@cache
def svg(name: str) -> str:
    """The <svg> element of an icon."""
    return _archive().read(f"{name}.svg").decode()


@cache
def _archive() -> ZipFile:
    return ZipFile(_icons.ICONS_DIR / "tabler-icons.zip")
