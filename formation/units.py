"""Numbers with units as users write them: "300ms", "0.3s", "30%"."""

_UNITS = {"ms": 1e-3, "s": 1.0, "min": 60.0}
_NUMBER = r"^\s*[+-]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][+-]?[0-9]+)?\s*"
SECONDS, SHARE = rf"{_NUMBER}({'|'.join(_UNITS)})?\s*$", rf"{_NUMBER}%?\s*$"
"""Patterns of such text, for editors."""


def seconds(value: object) -> object:
    """Seconds from text with a unit (ms, s, min; none means s). Other types pass through unchanged.

    Raises:
        ValueError: the text is not a number with one of the units.
    """
    if not isinstance(value, str):
        return value
    text = value.strip()
    for unit in ("ms", "min", "s"):
        if text.endswith(unit):
            return _number(text[: -len(unit)], value, "a time such as 300ms, 0.3s or 2min") * _UNITS[unit]
    return _number(text, value, "a time such as 300ms, 0.3s or 2min")


def share(value: object) -> object:
    """A share in 0..1 from "30%" or "0.3". Other types pass through unchanged.

    Raises:
        ValueError: the text is not a number.
    """
    if not isinstance(value, str):
        return value
    text = value.strip()
    if text.endswith("%"):
        return _number(text[:-1], value, "a share such as 30% or 0.3") / 100.0
    return _number(text, value, "a share such as 30% or 0.3")


def _number(text: str, whole: str, expected: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise ValueError(f"expected {expected}; got {whole!r}") from None
