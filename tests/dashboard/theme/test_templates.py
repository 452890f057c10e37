"""Laws of the templates: every text is escaped, their files are installed, and their classes are in the style sheet."""

import re
import tomllib
from importlib.resources import files
from pathlib import Path

import pytest

from dashboard.panels import event_log
from dashboard.theme.palette import DARK, LIGHT
from dashboard.theme.templates import render, style_element
from network.values import Event
from tests.builders import state

ROOT = Path(__file__).parents[3]
DATA = sorted(file for file in (ROOT / "dashboard").rglob("*") if file.suffix in (".html", ".css", ".svg"))
EVIL = "<img src=x onerror=alert(1)>"


def test_texts_from_elsewhere_are_escaped() -> None:
    message = state(events=(Event(1, 0.0, "fault", EVIL),))
    html = event_log.event_log(message)
    assert "<img" not in html
    assert "&lt;img" in html


def test_links_in_texts_get_an_arrow_after_they_were_escaped() -> None:
    html = event_log.event_log(state(events=(Event(1, 0.0, "fault", "1->2: <cut>"),)))
    assert "1→2: &lt;cut&gt;" in html


def test_data_files_are_found_in_the_installed_package() -> None:
    """Where they are installed, they are beside their modules; the wheel has whole folders, and git leaves none out."""
    assert len(DATA) > 8
    for file in DATA:
        found = files("dashboard").joinpath(file.relative_to(ROOT / "dashboard").as_posix())
        assert found.read_text(encoding="utf-8") == file.read_text(encoding="utf-8")
    with (ROOT / "pyproject.toml").open("rb") as project:
        wheel = tomllib.load(project)["tool"]["hatch"]["build"]["targets"]["wheel"]
    assert "dashboard" in wheel["packages"]
    assert not {"include", "exclude", "only-include"} & set(wheel)
    ignored = (ROOT / ".gitignore").read_text().split()
    kept = [pattern for pattern in ignored if not pattern.endswith("/")]
    left_out = [file.name for file in DATA if any(file.match(pattern) for pattern in kept)]
    assert left_out == [], "hatch leaves out what git ignores"


@pytest.mark.parametrize("file", [file for file in DATA if file.parent.name == "panels"], ids=lambda file: file.name)
def test_a_template_has_a_module_that_fills_it_in(file: Path) -> None:
    name = f'"panels/{file.name}"'
    assert [module for module in (ROOT / "dashboard").rglob("*.py") if name in module.read_text(encoding="utf-8")]


@pytest.mark.parametrize("file", [file for file in DATA if file.parent.name == "panels"], ids=lambda file: file.name)
def test_the_classes_of_a_template_are_in_the_style_sheet(file: Path) -> None:
    used = set(re.findall(r"\be-[a-z-]+", file.read_text(encoding="utf-8")))
    assert used <= set(re.findall(r"\.(e-[a-z-]+)", style_element()))


def test_the_style_sheet_names_only_colours_that_the_palettes_have() -> None:
    sheet = style_element()
    colours = set(re.findall(r"--([a-z0-9-]+):#", sheet))
    assert set(re.findall(r"var\(--([a-z0-9-]+)\)", sheet)) <= colours
    for palette, scheme in ((DARK, "dark"), (LIGHT, "light")):
        block = re.search(rf'scheme="{scheme}"\]{{(--[^}}]*)}}', sheet)
        assert block is not None
        assert f"--ok:#{palette.ok};" in block[1]


def test_a_value_that_is_missing_is_an_error() -> None:
    with pytest.raises(Exception, match="undefined"):
        render("panels/comparison.html")
