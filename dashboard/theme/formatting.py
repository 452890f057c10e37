"""How numbers, links and colours are written on the page. Every string that comes from elsewhere is escaped."""

from collections.abc import Mapping
from html import escape

MUTED = "color:var(--muted)"
FONT = "font-size:12px;line-height:1.35"
LINE = "border-top:1px solid rgba(128,140,160,.15)"
TABLE = "width:100%;border-collapse:collapse"


def light(level: float) -> str:
    """Green, amber or red for a level of trouble: 0 none, 1 lost."""
    return "var(--ok)" if level < 0.5 else "var(--warn)" if level < 1.0 else "var(--bad)"


def length(metres: float) -> tuple[str, str]:
    """A length and its unit, with as many digits as mean something."""
    mm = 1e3 * metres
    if mm < 0.0995:
        return f"{1e3 * mm:.0f}", "µm"
    return (f"{mm:.2f}" if mm < 9.995 else f"{mm:.1f}" if mm < 99.95 else f"{mm:.0f}"), "mm"


def duration(seconds: float) -> tuple[str, str]:
    """A time and its unit."""
    return (f"{1e3 * seconds:.0f}", "ms") if seconds < 0.9995 else (f"{seconds:.1f}", "s")


def arrow(text: str) -> str:
    """Escaped text in which links have a proper arrow."""
    return escape(text).replace("-&gt;", "→")


def remark(text: str) -> str:
    """A line of small print."""
    return f'<div style="{FONT};{MUTED};padding:8px 10px">{escape(text)}</div>'


def fault_text(fault: Mapping[str, object]) -> str:
    """A fault in a few words."""
    if fault.get("cut"):
        return "cut"
    words = []
    for key, value in fault.items():
        if isinstance(value, bool) or not isinstance(value, int | float):
            words.append(key.replace("_", " ") if value is True else f"{value}")
        elif key in ("latency", "jitter"):
            words.append(f"{key} {1e3 * value:.4g} ms")
        elif key in ("loss", "duplicate", "reorder", "corrupt"):
            words.append(f"{key} {100 * value:.3g} %")
        else:
            words.append(f"{key} {value:.4g}")
    return ", ".join(words)


def legend() -> str:
    """What the lines of the scene mean."""
    ramp = "linear-gradient(90deg,var(--ok),var(--warn),var(--bad))"
    rows = (
        ("border-top:3px solid var(--r1);width:28px", "own plan, two seconds ahead"),
        ("border-top:2px dashed var(--r1);width:28px", "that plan as its neighbour still believes it"),
        ("border:2px solid var(--muted);border-radius:50%;width:11px;height:11px", "where it should be"),
        (f"background:{ramp};height:5px;width:28px;border-radius:2px", "edge error to 20 mm, arrow age to 500 ms"),
        ("border-top:2px dashed var(--bad);width:28px", "no plan for half a second: lost"),
        ("border:1.5px dashed var(--ghost);border-radius:50%;width:11px;height:11px", "ghost: another controller"),
    )
    frame = "width:30px;display:flex;justify-content:center;flex:none"
    lines = "".join(
        f'<div style="display:flex;align-items:center;gap:10px;margin:3px 0"><span style="{frame}">'
        f'<span style="{mark}"></span></span><span>{text}</span></div>'
        for mark, text in rows
    )
    return f'<div style="font-size:11px;padding:0 10px 6px">{lines}</div>'


def plot_title(name: str, unit: str, marks: tuple[tuple[str, str, bool], ...]) -> str:
    """The line above a plot: its name, its unit, and the colour and meaning of its lines, which may be dashed."""
    series = "".join(
        f'<span style="color:{colour};margin-left:10px">{"┅" if dashed else "●"} {text}</span>'
        for colour, text, dashed in marks
    )
    return (
        '<div style="display:flex;font-size:12px;padding:0 16px 0 10px;margin-bottom:-8px">'
        f'<b>{name}</b><span style="{MUTED};margin-left:8px">{unit}</span>'
        f'<span style="margin-left:auto;font-size:11px">{series}</span></div>'
    )
