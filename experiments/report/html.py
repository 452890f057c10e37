"""The report as one HTML page (report.html) that needs no other file: style and figures are inside."""

import base64
import re
from collections.abc import Callable
from pathlib import Path

from jinja2 import Environment, FileSystemLoader, StrictUndefined
from markupsafe import Markup, escape

from experiments.report.report import MARKS, Picture, Report
from experiments.report.table import Table, shown

TEMPLATE = "report.html"
_CLASSES = {"holds": "holds", "holds in part": "part", "does not hold": "fails", "not judged": "none"}


def html(report: Report, svg: Callable[[Picture], bytes]) -> str:
    """The page.

    Args:
        report: its content.
        svg: gives the bytes of a picture's SVG file.
    """
    place = FileSystemLoader(Path(__file__).parent)
    environment = Environment(loader=place, autoescape=True, undefined=StrictUndefined, keep_trailing_newline=True)
    environment.filters |= {
        "inline": inline,
        "shown": shown,
        "svg": lambda picture: base64.b64encode(svg(picture)).decode("ascii"),
    }
    environment.tests |= {
        "table": lambda block: isinstance(block, Table),
        "picture": lambda block: isinstance(block, Picture),
    }
    return environment.get_template(TEMPLATE).render(report=report, marks=MARKS, classes=_CLASSES)


def inline(text: str) -> Markup:
    """Text as HTML: everything escaped, then **bold**, `code` and [words](#anchor)."""
    escaped = str(escape(text))
    escaped = re.sub(r"`([^`]+)`", r"<code>\1</code>", escaped)
    escaped = re.sub(r"\*\*([^*]+)\*\*", r"<strong>\1</strong>", escaped)
    return Markup(re.sub(r"\[([^]]+)\]\((#[\w-]+)\)", r'<a href="\2">\1</a>', escaped))
