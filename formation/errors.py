"""The exceptions of the project.

EchelonError            a mistake of the user or of a peer; its text is one line that says what was expected
├── ScenarioError       the user's scenario file or an override of it
├── StudyError          the user's study file or an override of it
├── FaultError          a fault that does not make sense, or a link that does not exist
└── WireError           a peer's bytes (network/codec.py)
"""

import difflib
from collections.abc import Iterable
from typing import Self


class Line(str):
    """A line about a mistake, which knows of which key it is and what there is to choose from."""

    path: str
    choices: tuple[str, ...]

    def __new__(cls, text: str, path: str = "", choices: Iterable[str] = ()) -> Self:
        """A line."""
        line = super().__new__(cls, text)
        line.path, line.choices = path, tuple(choices)
        return line

    def __add__(self, more: str) -> Self:
        return type(self)(super().__add__(more), self.path, self.choices)


class EchelonError(Exception):
    """A mistake that a caller may report to the user as one line."""

    def __init__(self, text: str = "", *, of: str = "") -> None:
        """With its text.

        Args:
            text: for the user.
            of: a Line that knows more than the text, if the text is none itself.
        """
        super().__init__(text)
        line = of or text
        self.path: str = getattr(line, "path", "")
        """The key that is wrong, such as link.latency; empty if it is none. Of several, the first."""
        self.choices: tuple[str, ...] = getattr(line, "choices", ())
        """What there is instead, if it is to be chosen from."""


class ScenarioError(EchelonError):
    """A scenario that cannot be run; one line per mistake."""


class StudyError(EchelonError):
    """A study that cannot be run; one line per mistake."""


class FaultError(EchelonError):
    """A fault, preset or link that does not make sense."""


class WireError(EchelonError):
    """Bytes from a peer that are not a valid message."""


def unknown(what: str, got: str, choices: Iterable[str]) -> Line:
    """Text for a name that does not exist: what was got, what there is, and the nearest of it."""
    names = list(choices)
    near = difflib.get_close_matches(got, names, n=1)
    hint = f" (did you mean {near[0]}?)" if near else ""
    text = f"{what}: expected one of {', '.join(names) or 'nothing'}; got {got!r}{hint}"
    return Line(text, what.partition(":")[0], names)
