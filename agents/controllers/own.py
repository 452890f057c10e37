"""Controllers of users' own: what is expected of a class, and how one gets its place among the built-in ones.

A class `Name(task, options)` with `plan(observation) -> Solution`. Optional class attributes: `Options`, a pydantic
model of keys of its own for [controller]; `ages_plans`; `colour`; `protocol`.
"""

import inspect
import re
from typing import Any, Literal, cast

from pydantic import BaseModel, create_model

from agents.controllers.guarded import Guarded
from agents.controllers.interface import PROTOCOL, Controller
from agents.controllers.registry import OWN
from agents.controllers.task import Task
from formation.errors import ScenarioError
from formation.loading.load import differs, load, unpack
from formation.loading.source import LOADED, Source, admitted
from formation.scenario.controllers import SHARED_KEYS, ControllerOptions
from formation.scenario.registry import ControllerSpec, check_free, register
from formation.scenario.scenario import Scenario
from formation.scenario.user_code import UserCode


def load_controller(spec: str) -> Source:
    """Load what a command line or an API call names, and register it.

    Args:
        spec: FILE.py:CLASS, package.module:CLASS, or the name of an entry point.

    Raises:
        ScenarioError: it cannot be had, or is not what is expected of a controller; one line.
    """
    return _admit(*load(spec, "controller"))


def admit(source: Source) -> Source:
    """Load and register what was read elsewhere or earlier. Raises ScenarioError."""
    return _admit(*unpack(source))


def _admit(source: Source, found: type) -> Source:
    _check(found, source.origin)
    check_free(source.attribute)
    source = admitted(source)
    options = _options(found, source)
    defaults = {key: options.model_fields[key].default for key in SHARED_KEYS}
    code = UserCode(
        kind="controller",
        name=source.name,
        origin=source.origin,
        sha256=source.sha256,
        colour=str(getattr(found, "colour", "")).removeprefix("#"),
        ages_plans=bool(getattr(found, "ages_plans", True)),
        defaults={k: v for k, v in defaults.items() if v != ControllerOptions.model_fields[k].default},
    )
    register(ControllerSpec(options, code.colour, ages_plans=code.ages_plans, code=code))

    def make(scenario: Scenario, robot: int, task: Task) -> Controller:
        return Guarded(found, task, scenario.controller, source)

    OWN[source.name] = make
    return source


def check_loaded(codes: list[UserCode], name: str) -> None:
    """Refuse a run whose controller is a user's own and is not loaded here, or is another text here.

    Args:
        codes: of the run.
        name: of the controller in question.

    Raises:
        ScenarioError: one line with the option to type.
    """
    for code in codes:
        if code.kind == "controller" and code.name == name:
            here = LOADED.get(("controller", name))
            if here is None or here.sha256 != code.sha256:
                raise ScenarioError(
                    differs("controller", name, code.origin, code.sha256, here.sha256 if here else None)
                )


def _check(found: type, origin: str) -> None:
    """Refuse a class that is no controller; the line says what is expected and what it has."""
    methods = [name for name in vars(found) if callable(getattr(found, name)) and not name.startswith("__")]
    plan = getattr(found, "plan", None)
    if not callable(plan):
        raise ScenarioError(
            f"{origin}: expected a method plan(observation); it has {', '.join(methods) or 'no method'}"
        )
    _takes(found, ("task", "options"), f"{found.__name__}", origin)
    _takes(plan, ("self", "observation"), "plan", origin)
    options = getattr(found, "Options", None)
    if options is not None and not (isinstance(options, type) and issubclass(options, BaseModel)):
        raise ScenarioError(f"{origin}: expected a pydantic model as Options; it has {options!r:.60}")
    if not isinstance(getattr(found, "ages_plans", True), bool):
        raise ScenarioError(f"{origin}: expected ages_plans to be True or False; it has {found.ages_plans!r:.60}")  # type: ignore[attr-defined]
    colour = getattr(found, "colour", "000000")
    if not (isinstance(colour, str) and re.fullmatch(r"#?[0-9A-Fa-f]{6}", colour)):
        raise ScenarioError(f"{origin}: expected colour to be six hexadecimal digits; it has {colour!r:.60}")
    if getattr(found, "protocol", PROTOCOL) != PROTOCOL:
        raise ScenarioError(f"{origin}: expected protocol = {PROTOCOL}; it has {found.protocol!r:.60}")  # type: ignore[attr-defined]


def _takes(called: Any, expected: tuple[str, ...], name: str, origin: str) -> None:
    try:
        signature = inspect.signature(called)
    except (TypeError, ValueError):
        return  # of compiled code; it fails when it is called, if at all
    try:
        signature.bind(*expected)
    except TypeError:
        words = ", ".join(word for word in expected if word != "self")
        raise ScenarioError(f"{origin}: expected {name}({words}); it has {name}{_shown(signature)}") from None


def _shown(signature: inspect.Signature) -> str:
    return f"({', '.join(str(p) for p in signature.parameters.values() if p.name != 'self')})"


def _options(found: type, source: Source) -> type[ControllerOptions]:
    """The model of its [controller] table: the keys that every controller has, and its own."""
    own: Any = getattr(found, "Options", None)
    bases = (
        (ControllerOptions,)
        if own is None
        else (own,)
        if issubclass(own, ControllerOptions)
        else (own, ControllerOptions)
    )
    taken = [key for key in getattr(own, "model_fields", {}) if key == "name"]
    if taken and not issubclass(own, ControllerOptions):
        raise ScenarioError(f"{source.origin}: expected Options without a key name; every controller has it already")
    fields: dict[str, Any] = {"name": (Literal[source.name], source.name)}
    about = inspect.getdoc(own or found) or found.__name__
    name = f"{found.__name__}Options"
    model: Any = create_model(name, __base__=bases, __module__=__name__, __doc__=about, **fields)
    return cast("type[ControllerOptions]", model)
