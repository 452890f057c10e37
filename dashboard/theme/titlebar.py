"""The title bar, and viser's own colours."""

import base64

import viser

from dashboard.theme.palette import Palette
from dashboard.theme.templates import render


def apply_theme(gui: viser.GuiApi, palette: Palette) -> None:
    """Show all pages in this theme, with the project's title."""
    gui.configure_theme(
        dark_mode=palette.dark,
        show_logo=False,
        show_share_button=False,
        brand_color=(60, 150, 220),
        titlebar_content=viser.theme.TitlebarConfig(
            buttons=(),
            image=viser.theme.TitlebarImage(
                image_url_light=_logo("#16202c"), image_url_dark=_logo("#f1f4f8"), image_alt="Echelon", href=None
            ),
        ),
    )


def _logo(ink: str) -> str:
    """The title as a data URL, so that the page requests nothing for it."""
    svg = render("theme/logo.svg", ink=ink)
    return "data:image/svg+xml;base64," + base64.b64encode(svg.encode()).decode()
