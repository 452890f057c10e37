"""Views of a flat array, for states of many arrays that compiled code takes as one or two.

In compiled code a view costs nothing: it is an address and a shape, without the reference that numba keeps for a slice
(0.04 us each). The flat array has to outlive it, as an argument of the kernel that makes it does.
"""

from typing import Any

from numba.core import cgutils, types
from numba.extending import intrinsic, overload
from numba.np import arrayobj

_CODE: Any = cgutils
_ARRAYS: Any = arrayobj
"""Parts of numba without types."""


def shaped(flat: Any, at: int, shape: tuple[int, ...]) -> Any:
    """The array of this shape that begins at element `at` of a flat one; a view, contiguous."""
    size = 1
    for length in shape:
        size *= length
    return flat[at : at + size].reshape(shape)


def _coded(context: Any, flat: Any, at: Any, shape: Any) -> Any:
    """`shaped` in machine code."""
    view = types.Array(flat.dtype, shape.count, "C")

    def generate(target: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        source = _ARRAYS.make_array(flat)(target, builder, arguments[0])
        lengths = _CODE.unpack_tuple(builder, arguments[2], shape.count)
        itemsize = target.get_constant(types.intp, target.get_abi_sizeof(target.get_data_type(flat.dtype)))
        strides = [itemsize]
        for length in reversed(lengths[1:]):
            strides.insert(0, builder.mul(strides[0], length))
        found = _ARRAYS.make_array(view)(target, builder)
        _ARRAYS.populate_array(found, builder.gep(source.data, [arguments[1]]), lengths, strides, itemsize, None)
        return found._getvalue()

    return view(flat, at, shape), generate


_shaped: Any = intrinsic(_coded)


@overload(shaped, inline="always")
def _shaped_for(flat: Any, at: Any, shape: Any) -> Any:
    """What compiled code calls for `shaped`; numba wants the same signature, annotations included."""

    def view(flat: Any, at: Any, shape: Any) -> Any:
        return _shaped(flat, at, shape)

    return view
