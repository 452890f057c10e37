"""The page of messages: the table of topics, and every message with its fields, of the types and their docstrings."""

import ast
from collections.abc import Mapping, Sequence
from pathlib import Path

from docs.markdown import code, table
from docs.topics_table import table as topics_table
from network.control import OPERATIONS
from network.topics import MESSAGES

NETWORK = Path(__file__).parents[1] / "network"
MESSAGES_INTRO = """\
# Messages

What the processes of a run send each other over Zenoh, made from the table of topics and the types of the messages.
A payload is the CRC-32 of what follows (4 bytes, little-endian) and a MessagePack map with `type`, `version` and
the fields below; arrays are raw little-endian float64. Any Zenoh client can take part: bytes that are not a valid
message are counted and dropped.

"""


def messages() -> str:
    """The topics, and each message with its fields."""
    types = _aliases(NETWORK / "fields.py")
    modules = ("messages", "requests", "stretch", "bodies", "values")
    classes = {name: found for module in modules for name, found in _classes(NETWORK / f"{module}.py").items()}
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
