"""Laws of the keys and signs: the help lists all that are bound or drawn, and no two are alike."""

import html
import json
import re
from importlib.resources import files
from typing import get_args

from dashboard.keys import CELLS, COMMANDS, DRIVING, HANDLE, HELP
from dashboard.overlay.help import help_html
from dashboard.overlay.overlay import SCRIPTS, _tables
from dashboard.page import Page
from dashboard.panels.ledger import _row
from dashboard.telemetry.marks import Kind
from dashboard.theme.signs import SIGNS
from network.values import Excursion


def test_every_key_that_the_page_binds_is_in_the_help_and_no_other(page: Page) -> None:
    commands = page._server.gui._command_handle_from_uuid.values()
    bound = {
        command._impl.props.label: command._impl.props.hotkey for command in commands if command._impl.props.hotkey
    }
    assert bound == {name: key for name, (key, _) in COMMANDS.items()}
    assert len(set(bound.values())) == len(bound), "two commands have one key"
    rows = re.findall(r"<tr><td>(.*?)</td><td>(.*?)</td></tr>", help_html())
    shown = {(key, html.unescape(what)) for keys, what in rows for key in re.findall(r"<kbd>(.*?)</kbd>", keys)}
    for name, key in bound.items():
        assert any(found == key and what.startswith(name) for found, what in shown)
    for one in (*DRIVING.values(), *HANDLE.values(), *CELLS.values()):
        assert (one.shown, one.meaning) in shown  # type: ignore[attr-defined]
    assert HELP in {key for key, _ in shown}


def test_the_scripts_have_no_keys_and_signs_of_their_own() -> None:
    tables = json.loads(json.dumps(_tables()))
    assert tables["handle"].keys() == HANDLE.keys()
    assert tables["cells"].keys() == CELLS.keys()
    assert set(get_args(Kind)) < set(tables["signs"]) == set(SIGNS)
    for name in (*(f"overlay/{script}.js" for script in SCRIPTS), "steering/wheel.js"):
        text = files("dashboard").joinpath(name).read_text(encoding="utf-8")
        assert not re.findall(r"\b(?:Key[A-Z]|Arrow[LRUD]\w+|Page(?:Up|Down))\b", text), name
        assert not set(re.findall(r"[▲✕○]|\([A-Z]\)", text)), name
    used = re.findall(
        r"""shortcut\("([^"]+)"\)""", files("dashboard").joinpath("overlay/time_line.js").read_text("utf-8")
    )
    assert {f"Time line: {name}" for name in used} == {name for name in COMMANDS if name.startswith("Time line")}


def test_every_sign_has_its_own_form_and_a_meaning_in_the_help() -> None:
    assert len({sign.form for sign in SIGNS.values()}) == len(SIGNS)
    text = help_html()
    assert all(sign.form in text and sign.meaning in text for sign in SIGNS.values())
    causes = {"": "unknown", "1->2 cut": "cut", "robot 2 stuck": "push", "1->2 late": "fault"}
    for cause, kind in causes.items():
        one = Excursion(1, 2, at=1.0, peak=0.03, peak_at=1.5, cause=cause, cause_at=0.5 if cause else None)
        assert _row(one, 3, chosen=False).sign == SIGNS[kind]
