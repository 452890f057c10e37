"""Pages of the manual that follow from the program, made when the manual is built: a hook of mkdocs."""

import argparse
import ast
import json
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from cli.main import COMMANDS, whole_parser
from experiments.study import study as studies
from formation.bodies.presets import PRESETS as BODIES
from formation.faults import PRESETS as FAULTS
from formation.scenario.files import load, shipped
from formation.scenario.json_schema import json_schema
from formation.scenario.keys import TAG, Key, keys
from network.control import OPERATIONS
from network.reference import table as topics_table
from network.topics import MESSAGES

if TYPE_CHECKING:
    from mkdocs.config.defaults import MkDocsConfig
    from mkdocs.structure.files import Files

NETWORK = Path(__file__).parents[1] / "network"

KEYS_INTRO = """\
# Scenario keys

Every key of a scenario file, made from the program's own models. `echelon scenarios --keys` prints the same, and
`echelon schema` the JSON schema: an editor completes and checks a TOML file whose first line is `#:schema
./scenario.schema.json`. `--set key=value` overrides any of them. A time may be text with a unit (`"300ms"`,
`"2min"`), and so may a share (`"30%"`). *absent*: the key may be left out, and nothing stands for it.

## Of the whole scenario

"""
MESSAGES_INTRO = """\
# Messages

What the processes of a run send each other over Zenoh, made from the table of topics and the types of the messages.
A payload is the CRC-32 of what follows (4 bytes, little-endian) and a MessagePack map with `type`, `version` and
the fields below; arrays are raw little-endian float64. Any Zenoh client can take part: bytes that are not a valid
message are counted and dropped.

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


def table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A table in Markdown."""
    lines = [" | ".join(_cell(cell) for cell in row) for row in (head, ["---"] * len(head), *rows)]
    return "\n".join(f"| {line} |" for line in lines) + "\n"


def _cell(text: str) -> str:
    return " ".join(text.split()).replace("|", "\\|").replace("<", "&lt;").replace("[[", "&#91;[")


def code(text: str) -> str:
    """As code; nothing for nothing."""
    return f"`{text}`" if text else ""


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
        text += _keys_table(key for key in found if re.match(rf"{section.path}(\[\])?\.", key.path))
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


# ---------------------------------------------------------------- messages


def messages() -> str:
    """The topics, and each message with its fields."""
    types = _aliases(NETWORK / "fields.py")
    stretch, values = _classes(NETWORK / "stretch.py"), _classes(NETWORK / "values.py")
    classes = _classes(NETWORK / "messages.py") | stretch | values
    text = MESSAGES_INTRO + topics_table()
    for name, kind in MESSAGES.items():
        text += f"\n## {kind.__name__}\n\n`{name}`. {_first(classes[kind.__name__][0])}\n\n"
        text += _fields(classes[kind.__name__][1])
    text += "\n## What messages are made of\n\n" + table(
        ("type", "what it is"), [(code(n), t) for n, t in types.items()]
    )
    for name in ("Event", "LinkCounts", "Order"):
        text += f"\n### {name}\n\n{_first(classes[name][0])}\n\n" + _fields(classes[name][1])
    text += "\n## Operations\n\nA `Request` names one of these, with its arguments.\n\n"
    return text + table(("operation", "what it does", "arguments"), [_operation(name) for name in OPERATIONS])


def _operation(name: str) -> tuple[str, str, str]:
    model = OPERATIONS[name]
    arguments = [
        f"`{key}`" + (f": {field.description}" if field.description else "")
        for key, field in model.model_fields.items()
    ]
    return code(name), _first(model.__doc__ or ""), "; ".join(arguments)


def _fields(fields: Mapping[str, tuple[str, str]]) -> str:
    return table(
        ("field", "type", "what it is"), [(code(name), code(kind), text) for name, (kind, text) in fields.items()]
    )


def _first(docstring: str) -> str:
    """The first paragraph."""
    return " ".join(docstring.partition("\n\n")[0].split())


def _docstring_after(body: Sequence[ast.stmt], index: int) -> str:
    after = body[index + 1] if index + 1 < len(body) else None
    if isinstance(after, ast.Expr) and isinstance(after.value, ast.Constant) and isinstance(after.value.value, str):
        return " ".join(after.value.value.split())
    return ""


def _classes(file: Path) -> dict[str, tuple[str, dict[str, tuple[str, str]]]]:
    """Of each class its docstring, and of each field type and docstring."""
    found = {}
    for node in ast.parse(file.read_text("utf-8")).body:
        if isinstance(node, ast.ClassDef):
            fields = {
                item.target.id: (ast.unparse(item.annotation), _docstring_after(node.body, index))
                for index, item in enumerate(node.body)
                if isinstance(item, ast.AnnAssign) and isinstance(item.target, ast.Name)
            }
            found[node.name] = (ast.get_docstring(node) or "", fields)
    return found


def _aliases(file: Path) -> dict[str, str]:
    """Names of types, each with its docstring or else its definition."""
    body = ast.parse(file.read_text("utf-8")).body
    return {
        item.targets[0].id: _docstring_after(body, index) or code(ast.unparse(item.value))
        for index, item in enumerate(body)
        if isinstance(item, ast.Assign) and isinstance(item.targets[0], ast.Name) and item.targets[0].id != "STRICT"
    }


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
    "shipped.md": shipped_files,
    "commands.md": commands,
}
"""By the name of the page."""
