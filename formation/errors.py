"""The exceptions of the project.

EchelonError            a mistake of the user or of a peer; its text is one line that says what was expected
├── ScenarioError       the user's scenario file or an override of it
├── StudyError          the user's study file or an override of it
├── FaultError          a fault that does not make sense, or a link that does not exist
└── WireError           a peer's bytes (network/codec.py)
"""

import difflib
from collections.abc import Iterable


class EchelonError(Exception):
    """A mistake that a caller may report to the user as one line."""


class ScenarioError(EchelonError):
    """A scenario that cannot be run; one line per mistake."""


class StudyError(EchelonError):
    """A study that cannot be run; one line per mistake."""


class FaultError(EchelonError):
    """A fault, preset or link that does not make sense."""


class WireError(EchelonError):
    """Bytes from a peer that are not a valid message."""


def unknown(what: str, got: str, choices: Iterable[str]) -> str:
    """Text for a name that does not exist: what was got, what there is, and the nearest of it."""
    names = list(choices)
    near = difflib.get_close_matches(got, names, n=1)
    hint = f" (did you mean {near[0]}?)" if near else ""
    return f"{what}: expected one of {', '.join(names) or 'nothing'}; got {got!r}{hint}"
