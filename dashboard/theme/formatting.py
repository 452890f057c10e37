"""How numbers, links and health levels are written on the page; filters of the templates."""


def level_colour(level: float) -> str:
    """CSS colour of a health level: below 0.5 is green, below 1 amber, 1 and above red."""
    return "var(--ok)" if level < 0.5 else "var(--warn)" if level < 1.0 else "var(--bad)"


def length(metres: float) -> tuple[str, str]:
    """A length and its unit: one decimal below 10 mm, none above; no robot's place is told in finer steps."""
    mm = 1e3 * metres
    if 0.0 < abs(mm) < 0.05:
        return "< 0.1", "mm"
    return (f"{mm:.1f}" if abs(mm) < 9.95 else f"{mm:.0f}"), "mm"


def error(metres: float, noise: float) -> tuple[str, str]:
    """An error and its unit; "< noise" for one below what localisation can tell.

    Args:
        metres: the error [m].
        noise: standard deviation of what localisation measures [m]; 0 if it is exact: then every error has its number.
    """
    return length(metres) if abs(metres) >= noise else ("< noise", "")


def duration(seconds: float) -> tuple[str, str]:
    """A time and its unit."""
    return (f"{1e3 * seconds:.0f}", "ms") if seconds < 0.9995 else (f"{seconds:.1f}", "s")


def arrow(text: object) -> str:
    """The text of a link, or a text with links, with a proper arrow: "1→2"."""
    return str(text).replace("->", "→")
