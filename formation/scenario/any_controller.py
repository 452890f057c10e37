"""The [controller] table of a scenario: by its name, the model of a controller that this process knows."""

from typing import Annotated, Any, Union

from pydantic import BeforeValidator, Field, GetJsonSchemaHandler, SerializeAsAny, TypeAdapter, ValidationError

from formation.scenario.controllers import ControllerOptions
from formation.scenario.registry import CONTROLLERS, DEFAULT, unknown_controller
from formation.validation import as_lines, mistake, shown


def _controller(given: object) -> object:
    """The options of the controller that a table names, by its own model; the default one if it names none."""
    if isinstance(given, ControllerOptions):
        return given
    if not isinstance(given, dict):
        raise ValueError(f"expected a table; got {shown(given)}")
    table = {"name": DEFAULT, **given}
    spec = CONTROLLERS.get(table["name"]) if isinstance(table["name"], str) else None
    if spec is None:
        raise mistake("name", unknown_controller(str(table["name"])).partition(": ")[2], CONTROLLERS)
    try:
        return spec.options.model_validate(table)
    except ValidationError as error:  # its mistakes become those of the scenario
        raise as_lines(error, spec.options, [other.options for other in CONTROLLERS.values()]) from None


class _OneOfThem:
    """For the JSON schema: the table of one of the controllers that this process knows."""

    def __get_pydantic_json_schema__(self, _: Any, handler: GetJsonSchemaHandler) -> Any:
        models = tuple(spec.options for spec in CONTROLLERS.values())
        union: Any = Annotated[Union[models], Field(discriminator="name")]  # noqa: UP007  made of the table
        return handler(TypeAdapter(union).core_schema)


AnyController = Annotated[SerializeAsAny[ControllerOptions], BeforeValidator(_controller), _OneOfThem()]
