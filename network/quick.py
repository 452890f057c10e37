"""Constructors of frozen dataclasses that take a fifth of the time, for messages that are made at every tick.

The generated one costs 0.5 us a field: keywords pass through a dictionary on their way to `__init__`, which calls
`object.__setattr__` for each. The function made here gets them at once, and fills an instance of an open class of the
same layout, which then becomes one of the frozen class.
"""

from collections.abc import Callable
from dataclasses import MISSING, fields
from typing import Any, ParamSpec, TypeVar

P = ParamSpec("P")
T = TypeVar("T")


def maker(kind: Callable[P, T]) -> Callable[P, T]:
    """Makes what the frozen dataclass with slots `kind` makes of the same arguments."""
    own = fields(kind)  # type: ignore[arg-type]
    opened = type("Open", (), {"__slots__": tuple(f.name for f in own)})
    names: dict[str, Any] = {"opened": opened, "kind": kind, "new": object.__new__, "MISSING": MISSING}
    head, body = [], []
    for f in own:
        value, default = f.name, ""
        if f.default is not MISSING:
            names[f"default_{f.name}"], default = f.default, f"=default_{f.name}"
        elif f.default_factory is not MISSING:
            names[f"make_{f.name}"], default = f.default_factory, "=MISSING"
            value = f"make_{f.name}() if {f.name} is MISSING else {f.name}"
        head.append(f.name + default)
        body.append(f" made.{f.name} = {value}")
    lines = [f"def make({', '.join(head)}):", " made = new(opened)", *body, " made.__class__ = kind", " return made"]
    exec("\n".join(lines), names)
    make: Callable[P, T] = names["make"]
    return make
