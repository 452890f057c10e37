"""Jinja2 templates of the page's HTML, with autoescape: every text from elsewhere is escaped where it is inserted.

A template lies beside the module that fills it in (panels/robot_table.html beside panels/robot_table.py), and its
classes are those of theme/page.css.
"""

from functools import cache
from importlib.resources import files

from jinja2 import Environment, PackageLoader, StrictUndefined

from dashboard.theme import formatting
from dashboard.theme.palette import DARK, LIGHT


@cache
def _environment() -> Environment:
    made = Environment(
        loader=PackageLoader("dashboard", "."),
        autoescape=True,
        auto_reload=False,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    made.filters.update(
        metres=formatting.length,
        error=formatting.error,
        seconds=formatting.duration,
        arrow=formatting.arrow,
        level_colour=formatting.level_colour,
    )
    return made


def render(template: str, **values: object) -> str:
    """Fill in a template, named by its path in the dashboard: "panels/robot_table.html"."""
    return _environment().get_template(template).render(**values)


def style_element() -> str:
    """The style sheet theme/page.css as HTML, with the colours of both themes as its variables."""
    blocks = [f":root{{{_variables('dark-', DARK.named())}}}"]
    for palette in (DARK, LIGHT):
        scheme = "dark" if palette.dark else "light"
        blocks.append(f':root[data-mantine-color-scheme="{scheme}"]{{{_variables("", palette.named())}}}')
    rules = files("dashboard").joinpath("theme/page.css").read_text(encoding="utf-8")
    return f"<style>{''.join(blocks)}\n{rules}</style>"


def _variables(prefix: str, colours: dict[str, str]) -> str:
    return "".join(f"--{prefix}{name}:#{colour};" for name, colour in colours.items())
