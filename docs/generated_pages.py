"""Pages of the manual that follow from the program, made when the manual is built: a hook of mkdocs."""

import argparse
import json
import re
from collections.abc import Callable, Iterable, Mapping
from typing import TYPE_CHECKING, Any

from cli.main import COMMANDS, whole_parser
from docs.markdown import code, table
from docs.messages_page import messages
from experiments.study import study as studies
from experiments.trials.measures import MEASURES
from formation.bodies.presets import PRESETS as BODIES
from formation.faults import PRESETS as FAULTS
from formation.scenario.files import load, shipped
from formation.scenario.json_schema import json_schema, schema_of
from formation.scenario.keys import TAG, Key, keys

if TYPE_CHECKING:
    from mkdocs.config.defaults import MkDocsConfig
    from mkdocs.structure.files import Files

KEYS_INTRO = """\
# Scenario keys

Every key of a scenario file, made from the program's own models. `echelon scenarios --keys` prints the same, and
`echelon schema` the JSON schema: an editor completes and checks a TOML file whose first line is `#:schema
./scenario.schema.json`. `--set key=value` overrides any of them. A time may be text with a unit (`"300ms"`,
`"2min"`), and so may a share (`"30%"`). *absent*: the key may be left out, and nothing stands for it.

## Of the whole scenario

"""
STUDY_INTRO = """\
# Study keys

Every key of a study file, made from the program's own models ([what a study is](studies.md)).

## Of the whole study

"""
FAULTS_INTRO = """\
# Faults and bodies

## Faults of a link

What a link can do to messages: in `[link]` to all plans from the start, in `[[faults]]` at given times, on a live
run by `echelon fault` and on the page. A link is `"1->2"` (plans), `"world->1"` (poses) or `"1->world"` (commands);
`all` means every link that carries plans.

"""
BODIES_INTRO = """
## Bodies

`--bodies NAME`, or `bodies = "NAME"` in a scenario; any key of [bodies](scenario-keys.md#bodies) beside a preset
refines it. A key that a preset does not name has its default. Where each value is from stands in
`formation/bodies/presets.py`.

"""


def on_files(files: "Files", config: "MkDocsConfig") -> "Files":
    """Add the pages to the manual."""
    from mkdocs.structure.files import File  # noqa: PLC0415  not there where the tests run

    for name, make in PAGES.items():
        files.append(File.generated(config, name, content=make()))
    return files


# ---------------------------------------------------------------- scenario keys


def scenario_keys() -> str:
    """Every key of a scenario file."""
    found = keys()
    schema = json_schema()
    text = KEYS_INTRO
    top = [key for key in found if "." not in key.path and not key.type.startswith("table")]
    text += _keys_table(top)
    for section in (key for key in found if "." not in key.path and key.type.startswith("table")):
        name = f"[[{section.path}]]" if section.type == "tables" else f"[{section.path}]"
        text += f"\n## {section.path}\n\n`{name}`: {section.text}\n\n" + _kinds(section.path, schema)
        text += _keys_table(_inside(section.path, found))
    return text


def _keys_table(found: Iterable[Key]) -> str:
    head = ("key", "what it is", "unit", "range", "default")
    return table(head, [(_name(k), _what(k), k.unit, k.range, code(k.default)) for k in found])


def _name(key: Key) -> str:
    kinds = f" ({', '.join(key.of)})" if key.of else ""
    return f"`{key.path}`{kinds}"


def _what(key: Key) -> str:
    return key.text if key.type == TAG else f"{key.text} *{key.type}*"


def _kinds(name: str, schema: Mapping[str, Any]) -> str:
    """What each kind of a table is that is one of several."""
    choices = [choice["$ref"].rpartition("/")[2] for choice in schema["properties"][name].get("anyOf", ())
               if "$ref" in choice]  # fmt: skip
    if len(choices) < 2:
        return ""
    rows = []
    for choice in choices:
        definition = schema["$defs"][choice]
        tag = next(part["const"] for part in definition["properties"].values() if "const" in part)
        rows.append((code(tag), definition["description"].partition("\n\n")[0]))
    return table(("kind" if name == "path" else "name", "what it is"), rows) + "\n"


def study_keys() -> str:
    """Every key of a study file, and every measure."""
    found = keys(schema_of(studies.Study))
    text = STUDY_INTRO + _keys_table(key for key in found if "." not in key.path)
    for section in (key for key in found if "." not in key.path and _inside(key.path, found)):
        text += f"\n## {section.path}\n\n{section.text}\n\n" + _keys_table(_inside(section.path, found))
    rows = [(code(name), re.sub(r"[$\\]", "", measure.label), measure.unit) for name, measure in MEASURES.items()]
    return text + "\n## Measures\n\n" + table(("measure", "what it is", "unit"), rows)


def _inside(section: str, found: Iterable[Key]) -> list[Key]:
    return [key for key in found if re.match(rf"{section}(\[\])?\.", key.path)]


# ---------------------------------------------------------------- faults, bodies, what is shipped, commands


def faults_and_bodies() -> str:
    """The keys of a fault, and the presets of faults and bodies."""
    link = [key for key in keys() if key.path.startswith("link.")]
    text = FAULTS_INTRO
    text += table(("key", "what it does", "unit", "range"), [(code(k.path[5:]), k.text, k.unit, k.range) for k in link])
    rows = [(code(name), fault.words(), code(json.dumps(fault.plain()))) for name, fault in FAULTS.items()]
    text += "\n### Presets of faults\n\n`--faults NAME`, `echelon fault preset NAME`, or `preset` in `[[faults]]`.\n\n"
    text += table(("preset", "in words", "keys"), rows)
    text += BODIES_INTRO
    return text + table(("key", *map(code, BODIES)), _body_rows())


def _body_rows() -> list[list[str]]:
    flat = {name: dict(_flat(values)) for name, values in BODIES.items()}
    names = dict.fromkeys(key for values in flat.values() for key in values)
    return [[code(key), *(str(values.get(key, "")) for values in flat.values())] for key in names]


def _flat(values: Mapping[str, Any], above: str = "") -> Iterable[tuple[str, Any]]:
    for key, value in values.items():
        if isinstance(value, Mapping):
            yield from _flat(value, f"{above}{key}.")
        else:
            yield f"{above}{key}", value


def shipped_files() -> str:
    """The scenarios and studies that come with the project."""
    text = (
        "# Scenarios and studies\n\n## Scenarios\n\n`echelon run NAME`, `echelon up NAME`; files in `scenarios/`.\n\n"
    )
    found = [load(name) for name in shipped()]
    rows = [(code(s.name), str(s.size), s.path.kind, f"{s.duration:g}", s.source) for s in found]
    text += table(("scenario", "robots", "path", "duration s", "what it is"), rows)
    text += "\n## Studies\n\n`echelon study NAME`; files in `studies/`. [What a study is](studies.md).\n\n"
    every = [studies.load(name) for name in studies.shipped()]
    return text + table(("study", "trials", "what it asks"), [(code(s.name), str(s.trials), s.title) for s in every])


def commands() -> str:
    """Every command with its options."""
    text = "# Commands\n\nWhat `echelon COMMAND --help` prints. From a checkout: `./echelon COMMAND`.\n"
    parser = whole_parser()
    for name, command in _subcommands(parser).items():
        text += f"\n## {name}\n\n{COMMANDS[name][0].upper()}{COMMANDS[name][1:]}.\n\n" + _options(command)
        for action, inner in _subcommands(command).items():
            text += f"\n### {name} {action}\n\n" + _options(inner)
    return text


def _subcommands(parser: argparse.ArgumentParser) -> dict[str, argparse.ArgumentParser]:
    found = [action for action in parser._actions if isinstance(action, argparse._SubParsersAction)]
    return dict(found[0].choices) if found else {}


def _options(parser: argparse.ArgumentParser) -> str:
    rows = []
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction | argparse._HelpAction):
            continue
        value = action.metavar or (action.dest.upper() if action.nargs != 0 else "")
        shown = f"{', '.join(action.option_strings)} {value}" if action.option_strings else value or action.dest
        choices = f" ({', '.join(map(str, action.choices))})" if action.choices else ""
        rows.append((code(str(shown).strip()), (action.help or "").replace("%%", "%") + choices))
    return table(("option", "what it does"), rows) if rows else ""


PAGES: dict[str, Callable[[], str]] = {
    "scenario-keys.md": scenario_keys,
    "messages.md": messages,
    "faults-and-bodies.md": faults_and_bodies,
    "study-keys.md": study_keys,
    "shipped.md": shipped_files,
    "commands.md": commands,
}
"""By the name of the page."""
