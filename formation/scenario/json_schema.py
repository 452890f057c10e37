"""The JSON schema of scenario files, made of the models: editors complete keys by it and mark mistakes."""

from typing import Any

from pydantic import BaseModel
from pydantic.json_schema import GenerateJsonSchema

from formation.scenario.scenario import Scenario

BOUNDS = {"gt": "exclusiveMinimum", "ge": "minimum", "lt": "exclusiveMaximum", "le": "maximum"}
"""What pydantic calls the bounds of a number that is made of text, and JSON schema's own words."""


def json_schema() -> dict[str, Any]:
    """The schema of a scenario's file, in which a name may stand for a table and a file for the points."""
    schema = schema_of(Scenario)
    for table in schema["$defs"].values():
        if "file" in table["properties"]:  # which then holds the points
            table["required"] = [key for key in table.get("required", ()) if key != "points"]
    bodies = schema["properties"]["bodies"]
    presets = schema["$defs"]["Bodies"]["properties"]["preset"]["enum"]
    schema["properties"]["bodies"] = {
        "anyOf": [{"$ref": bodies.pop("$ref")}, {"type": "string", "enum": presets}],
        **bodies,
    }
    return {"$schema": GenerateJsonSchema.schema_dialect, **schema}


def schema_of(model: type[BaseModel]) -> dict[str, Any]:
    """The JSON schema of a model, in JSON schema's own words."""
    found: dict[str, Any] = _plain(model.model_json_schema())
    return found


def _plain(part: Any) -> Any:
    """The part with bounds in JSON schema's words, and unions whose tables need not say which they are."""
    if isinstance(part, list):
        return [_plain(one) for one in part]
    if not isinstance(part, dict):
        return part
    found = {}
    for key, value in part.items():
        if key == "oneOf" and "discriminator" in part:
            found["anyOf"] = _plain(value)  # a [controller] without a name is the default's
        elif key in BOUNDS and isinstance(value, int | float):
            found[BOUNDS[key]] = value
        elif key != "discriminator":
            found[key] = value if key in ("default", "const", "enum") else _plain(value)
    if "exclusiveMinimum" in found:
        found.pop("minimum", None)
    return found
