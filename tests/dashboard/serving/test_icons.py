"""The law of icons: they are viser's own, and its archive is opened once for all of them."""

from pathlib import Path
from typing import Literal
from zipfile import ZipFile

import pytest
from viser import _gui_api, _icons

from dashboard.serving import icons


def test_icons_are_those_of_viser_and_the_archive_is_opened_once(monkeypatch: pytest.MonkeyPatch) -> None:
    opened: list[Path] = []

    def opening(path: Path) -> ZipFile:
        opened.append(path)
        return ZipFile(path)

    monkeypatch.setattr(icons, "ZipFile", opening)
    monkeypatch.setattr(_gui_api, icons.NAME, _icons.svg_from_icon)
    icons._archive.cache_clear()
    icons.svg.cache_clear()
    icons.open_once()
    names: list[Literal["player-play", "player-pause", "refresh"]] = ["player-play", "player-pause", "refresh"]
    for name in names:
        assert getattr(_gui_api, icons.NAME)(name) == _icons.svg_from_icon(name)
    assert len(opened) == 1
