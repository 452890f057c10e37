"""What is known of code of a user's own without loading it: goes to the world, and comes back in its Setup."""

from collections.abc import Iterable
from typing import Annotated, Literal

from pydantic import ConfigDict, Field, TypeAdapter, ValidationError, create_model

from formation.errors import ScenarioError
from formation.loading.source import Kind
from formation.scenario.controllers import SHARED_KEYS, ControllerOptions
from formation.schema import Model


class UserCode(Model):
    """A class of a user's own."""

    kind: Kind
    """What it is for."""
    name: Annotated[str, Field(min_length=1, max_length=64)]
    """By which scenarios name it."""
    origin: Annotated[str, Field(max_length=1024)]
    """The file without its folder, or the module, and the class: "mine.py:HoldSlot"."""
    sha256: Annotated[str, Field(pattern=r"^[0-9a-f]{64}$")]
    """Of its text: who has another text has no part in the run."""
    colour: Annotated[str, Field(pattern=r"^[0-9A-Fa-f]{0,6}$")] = ""
    """Of a controller in figures, rrggbb; empty for a free one."""
    ages_plans: bool = True
    """Of a controller: whether received plans are rolled forward to now for it."""
    defaults: dict[str, int | float | bool | None] = Field(default_factory=dict)
    """Of a controller: its default values of the keys that every controller has, where they are others."""


SHOWN = {"kind", "name", "origin", "sha256"}
"""What summaries say of it."""


class OpaqueOptions(ControllerOptions):
    """Options of a controller that is not loaded here: its own keys were checked by who loaded it."""

    model_config = ConfigDict(extra="allow")


_LIST: TypeAdapter[list[UserCode]] = TypeAdapter(list[UserCode])


def to_text(codes: Iterable[UserCode]) -> str:
    """A list as one argument of a process."""
    return _LIST.dump_json([*codes], exclude_defaults=True).decode()


def from_text(text: str) -> list[UserCode]:
    """The list that `to_text` wrote. Raises ScenarioError."""
    try:
        return _LIST.validate_json(text)
    except ValidationError as error:
        raise ScenarioError(
            f"--controllers: expected a list as `to_text` writes it; {error.errors()[0]['msg']}"
        ) from None


def opaque_options(code: UserCode) -> type[ControllerOptions]:
    """The model of the options of a controller that is not loaded here."""
    defaults = {
        key: (ControllerOptions.model_fields[key].rebuild_annotation(), code.defaults[key])
        for key in SHARED_KEYS
        if key in code.defaults
    }
    name = (Literal[code.name], code.name)
    return create_model(f"{code.name}Options", __base__=OpaqueOptions, name=name, **defaults)  # type: ignore[call-overload,no-any-return]
