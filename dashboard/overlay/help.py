"""The help: every key, colour and mark of the page, made of the tables that the page itself uses."""

from dashboard.keys import HELP, groups
from dashboard.theme.limits import DISTANCE_LIMIT, TRACKING_LIMIT
from dashboard.theme.palette import DARK
from dashboard.theme.signs import SIGNS
from dashboard.theme.templates import render


def help_html() -> str:
    """The HTML that the dialog shows."""
    return render(
        "overlay/help.html",
        key=HELP,
        groups=groups(),
        signs=SIGNS.values(),
        robots=range(1, len(DARK.identity) + 1),
        distance=1e3 * DISTANCE_LIMIT,
        tracking=1e3 * TRACKING_LIMIT,
    )
