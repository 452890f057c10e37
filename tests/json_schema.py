"""What a JSON schema accepts, for the words that ours uses; any other word of a schema is an error."""

import re
from typing import Any

KNOWN = {
    "$schema", "$defs", "title", "description", "default", "x-unit",
    "$ref", "anyOf", "type", "const", "enum", "pattern", "properties", "required", "additionalProperties",
    "items", "prefixItems", "minItems", "maxItems", "minimum", "maximum", "exclusiveMinimum", "exclusiveMaximum",
}  # fmt: skip
TYPES: dict[str, Any] = {"object": dict, "array": list, "string": str, "boolean": bool, "null": type(None)}


def accepts(schema: dict[str, Any], value: Any, whole: dict[str, Any] | None = None) -> bool:
    """Whether the value is as the schema says."""
    whole = schema if whole is None else whole
    assert set(schema) <= KNOWN, set(schema) - KNOWN
    if "$ref" in schema and not accepts(whole["$defs"][schema["$ref"].removeprefix("#/$defs/")], value, whole):
        return False
    if "anyOf" in schema and not any(accepts(choice, value, whole) for choice in schema["anyOf"]):
        return False
    if "type" in schema and not _is(schema["type"], value):
        return False
    if ("const" in schema and value != schema["const"]) or ("enum" in schema and value not in schema["enum"]):
        return False
    if isinstance(value, dict):
        return _table(schema, value, whole)
    if isinstance(value, list):
        return _list(schema, value, whole)
    if isinstance(value, str):
        return "pattern" not in schema or re.search(schema["pattern"], value) is not None
    return not isinstance(value, int | float) or isinstance(value, bool) or _within(schema, value)


def _is(name: str, value: Any) -> bool:
    if name in ("number", "integer"):
        whole = name == "number" or float(value).is_integer() if isinstance(value, int | float) else False
        return whole and not isinstance(value, bool)  # 1.0 is a whole number too
    return isinstance(value, TYPES[name])


def _within(schema: dict[str, Any], value: float) -> bool:
    return (
        schema.get("minimum", value) <= value <= schema.get("maximum", value)
        and ("exclusiveMinimum" not in schema or value > schema["exclusiveMinimum"])
        and ("exclusiveMaximum" not in schema or value < schema["exclusiveMaximum"])
    )


def _table(schema: dict[str, Any], value: dict[str, Any], whole: dict[str, Any]) -> bool:
    properties = schema.get("properties", {})
    if not set(schema.get("required", ())) <= set(value):
        return False
    if schema.get("additionalProperties", True) is False and set(value) - set(properties):
        return False
    return all(accepts(properties[key], part, whole) for key, part in value.items() if key in properties)


def _list(schema: dict[str, Any], value: list[Any], whole: dict[str, Any]) -> bool:
    if not schema.get("minItems", 0) <= len(value) <= schema.get("maxItems", len(value)):
        return False
    first = schema.get("prefixItems", [])
    rest = value[len(first) :] if "items" in schema else []
    return all(accepts(part, one, whole) for part, one in zip(first, value, strict=False)) and all(
        accepts(schema["items"], one, whole) for one in rest
    )
