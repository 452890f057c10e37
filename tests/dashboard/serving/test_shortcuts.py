"""The law of the shortcuts: a value is set to what viser would set it to."""

from collections.abc import Callable
from typing import Any, get_type_hints

import numpy as np
import pytest
import viser
from viser import _messages
from viser._assignable_props_api import AssignablePropsBase

from dashboard.serving import shortcuts

VALUES = (
    np.array([[0.25, 0.5, 1.0]]),
    np.array([[0.25, 0.5, 1.0]], dtype=np.float32),
    np.array([[1, 200, 300]]),
    np.array([[1, 200, 3]], dtype=np.uint8),
    [[0.1, 0.2, 0.3]],
    (0.1, 0.2, 0.3),
    (1, 2, 3),
    "a text",
    True,
    3,
    0.5,
    None,
)
PROPERTIES = sorted(
    {
        (name, str(hint)): (name, hint)
        for kind in vars(_messages).values()
        if isinstance(kind, type) and kind.__name__.endswith("Props")
        for name, hint in get_type_hints(kind).items()
    }.values(),
    key=str,
)


def test_viser_has_the_methods_that_are_replaced() -> None:
    assert shortcuts._viser_cast.__name__ == shortcuts.CAST
    assert shortcuts._viser_cast.__module__ == AssignablePropsBase.__module__
    assert hasattr(viser.CameraHandle, shortcuts.ORIENT)


@pytest.mark.parametrize(("name", "hint"), PROPERTIES)
def test_a_property_is_cast_as_viser_casts_it(name: str, hint: Any) -> None:
    handle: Any = object.__new__(viser.PointCloudHandle)
    for value in VALUES:
        found, wanted = (_tried(way, handle, hint, value, name) for way in (shortcuts.cast, shortcuts._viser_cast))
        assert type(found) is type(wanted)
        if isinstance(wanted, np.ndarray):
            assert found.dtype == wanted.dtype
            np.testing.assert_array_equal(found, wanted)
        else:
            assert found == wanted


def _tried(way: Callable[..., Any], *arguments: Any) -> Any:
    """What it gives, or the name of its error."""
    try:
        return way(*arguments)
    except (AttributeError, TypeError, ValueError) as error:
        return type(error).__name__
