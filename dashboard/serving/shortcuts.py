"""Ways round what viser does for every value that is set, some hundred times a second, and that is of no use here.

It makes the type hints anew with which it compares a property's own, and computes the orientation of a camera that was
only moved; nothing here asks for that, and pages compute their own.
"""

from typing import Any

import numpy as np
import numpy.typing as npt
from viser import CameraHandle
from viser._assignable_props_api import AssignablePropsBase, colors_to_uint8

FLOATS: dict[Any, type[np.floating[Any]]] = {
    npt.NDArray[np.float16]: np.float16,
    npt.NDArray[np.float32]: np.float32,
    npt.NDArray[np.float64]: np.float64,
}
BYTES: Any = npt.NDArray[np.uint8]
CAST, ORIENT = "_cast_value_recursive", "_update_wxyz"
"""Of viser's methods."""
_viser_cast = getattr(AssignablePropsBase, CAST)


def take() -> None:
    """Have viser take them."""
    setattr(AssignablePropsBase, CAST, cast)
    setattr(CameraHandle, ORIENT, lambda camera: None)


def cast(handle: "AssignablePropsBase[Any]", hint: Any, value: Any, name: str) -> Any:
    """The value as a property of this type hint and name has it."""
    kind = FLOATS.get(hint)
    if kind is not None:
        return np.asarray(value).astype(kind)
    if "color" in name and hint == BYTES:
        return colors_to_uint8(value)
    return _viser_cast(handle, hint, value, name) if isinstance(value, tuple) else value
