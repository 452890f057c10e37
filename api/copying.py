"""Copies of a simulation: by `copy`, or as bytes by `pickle`. What follows is the same to the last bit in each."""

import copy
import io
import pickle
from collections.abc import Mapping
from typing import Any

from formation.errors import EchelonError
from formation.faults import PERFECT
from formation.scenario.controllers import ControllerOptions
from formation.scenario.registry import CONTROLLERS

LINK = "perfect"
"""In bytes, the one fault that is compared by identity ..."""
OPTIONS = "options"
"""... and the type of the options of a controller, by its name: that of a user's own is made when it is loaded."""


def copied(state: Mapping[str, Any], memo: dict[int, Any]) -> dict[str, Any]:
    """A deep copy of what an object holds.

    Args:
        state: by attribute.
        memo: of `copy.deepcopy`; what it has is shared.

    Raises:
        EchelonError: a part cannot be copied, such as a lock in a controller of a user's own.
    """
    memo[id(PERFECT)] = PERFECT
    try:
        return copy.deepcopy(dict(state), memo)
    except Exception as error:  # of a user's class: any that it likes
        raise _refused("copied", error) from error


def dumped(state: Mapping[str, Any]) -> bytes:
    """The same as bytes, for a process that has loaded the same code of users' own. Raises EchelonError likewise."""
    file = io.BytesIO()
    try:
        _Pickler(file, protocol=pickle.HIGHEST_PROTOCOL).dump(dict(state))
    except Exception as error:  # likewise
        raise _refused("pickled", error) from error
    return file.getvalue()


def loaded(data: bytes) -> dict[str, Any]:
    """What `dumped` made bytes of. Raises EchelonError: a class is missing here."""
    try:
        found: dict[str, Any] = _Unpickler(io.BytesIO(data)).load()
    except Exception as error:  # likewise
        raise EchelonError(
            f"simulation: expected the code that it was pickled with; {type(error).__name__}: {error} (load its "
            "controller and bodies before, with echelon.load)"
        ) from error
    return found


class _Pickler(pickle.Pickler):
    def persistent_id(self, value: Any) -> tuple[str, str] | None:
        if value is PERFECT:
            return LINK, ""
        if isinstance(value, type) and issubclass(value, ControllerOptions):
            name = value.model_fields["name"].default
            if name in CONTROLLERS and CONTROLLERS[name].options is value:
                return OPTIONS, name
        return None


class _Unpickler(pickle.Unpickler):
    def persistent_load(self, what: tuple[str, str]) -> Any:
        kind, name = what
        return PERFECT if kind == LINK else CONTROLLERS[name].options


def _refused(how: str, error: Exception) -> EchelonError:
    return EchelonError(
        f"simulation: expected parts that can be {how}, those of code of your own too; {type(error).__name__}: {error}"
    )
