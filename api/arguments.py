"""What callers hand in: plain numbers of NumPy's, and one line for what is none."""

import os
from collections.abc import Mapping
from operator import index
from pathlib import Path
from typing import Any

import numpy as np

from formation.errors import EchelonError
from formation.validation import shown


def whole(name: str, value: object, least: int) -> int:
    """An integer of Python's or of NumPy's. Raises EchelonError: it is none, or less than `least`."""
    try:
        number = None if isinstance(value, bool) else index(value)  # type: ignore[arg-type]
    except TypeError:
        number = None
    if number is None or number < least:
        raise EchelonError(f"{name}: expected an integer, at least {least}; got {shown(value)}")
    return number


def plain(value: Any) -> Any:
    """The same with Python's own numbers instead of NumPy's, tables included: messages have no others."""
    if isinstance(value, Mapping):
        return {key: plain(inner) for key, inner in value.items()}
    return value.item() if isinstance(value, np.generic) else value


def check_folder(file: str | os.PathLike[str]) -> Path:
    """The file as a path. Raises EchelonError: its folder does not exist, so that it cannot be written."""
    path = Path(file)
    if not path.parent.is_dir():
        raise EchelonError(f"{path}: expected a file in a folder that exists; there is no {path.parent}")
    return path


def unwritable(file: str | os.PathLike[str], error: Exception) -> EchelonError:
    """For a file that could not be written."""
    reason = getattr(error, "strerror", None) or next(iter(str(error).splitlines()), type(error).__name__)
    return EchelonError(f"{os.fspath(file)}: expected a file that can be written; {reason}")
