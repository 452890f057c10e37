"""How numbers, links and health levels are written on the page; filters of the templates."""

from collections.abc import Mapping


def level_colour(level: float) -> str:
    """CSS colour of a health level: below 0.5 is green, below 1 amber, 1 and above red."""
    return "var(--ok)" if level < 0.5 else "var(--warn)" if level < 1.0 else "var(--bad)"


def length(metres: float) -> tuple[str, str]:
    """A length and its unit, with three significant digits at most."""
    mm = 1e3 * metres
    if mm < 0.0995:
        return f"{1e3 * mm:.0f}", "µm"
    return (f"{mm:.2f}" if mm < 9.995 else f"{mm:.1f}" if mm < 99.95 else f"{mm:.0f}"), "mm"


def duration(seconds: float) -> tuple[str, str]:
    """A time and its unit."""
    return (f"{1e3 * seconds:.0f}", "ms") if seconds < 0.9995 else (f"{seconds:.1f}", "s")


def arrow(text: str) -> str:
    """A text in which links have a proper arrow: "1→2"."""
    return text.replace("->", "→")


def fault_text(fault: Mapping[str, object]) -> str:
    """A fault in a few words: "latency 200 ms, loss 30 %"."""
    if fault.get("cut"):
        return "cut"
    parts = []
    for key, value in fault.items():
        if isinstance(value, bool) or not isinstance(value, int | float):
            parts.append(key.replace("_", " ") if value is True else f"{value}")
        elif key in ("latency", "jitter"):
            parts.append(f"{key} {1e3 * value:.4g} ms")
        elif key in ("loss", "duplicate", "reorder", "corrupt"):
            parts.append(f"{key} {100 * value:.3g} %")
        else:
            parts.append(f"{key} {value:.4g}")
    return ", ".join(parts)
