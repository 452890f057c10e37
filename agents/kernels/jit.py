"""How numeric code is compiled: ahead of the first call, once per machine.

agents/kernels/jit_cache.py says where the result is kept.
"""

from collections.abc import Callable
from typing import Any

import numba

from agents.kernels.jit_cache import cache_folder, fetch_prebuilt

fetch_prebuilt()
setattr(numba.config, "CACHE_DIR", str(cache_folder()))  # noqa: B010  the module has no types

REAL, WHOLE, FLAG, NOTHING = numba.float64, numba.int64, numba.boolean, numba.void
VECTOR, MATRIX, TABLE = (numba.types.Array(REAL, n, "C", readonly=True) for n in (1, 2, 3))
"""Contiguous arrays that a kernel only reads, writable or not."""
STRIDED_VECTOR, STRIDED = (numba.types.Array(REAL, n, "A", readonly=True) for n in (1, 2))
"""The same with any layout; slower."""
FLAGS = numba.types.Array(numba.boolean, 1, "C", readonly=True)
VECTOR_OUT, MATRIX_OUT, TABLE_OUT = numba.float64[::1], numba.float64[:, ::1], numba.float64[:, :, ::1]
STRIDED_OUT = numba.float64[:, :]
WHOLE_VECTOR_OUT, WHOLE_MATRIX_OUT = numba.int64[::1], numba.int64[:, ::1]
"""Arrays that a kernel writes."""

kernel: Callable[..., Any] = numba.njit(cache=True, error_model="numpy", nogil=True)
"""Decorator for a function that other kernels call: compiled with its caller."""


def kernel_for(result: Any, *arguments: Any) -> Callable[..., Any]:
    """Decorator for a function that Python calls: compiled, or loaded from the cache, on import."""
    decorate: Callable[..., Any] = numba.njit(result(*arguments), cache=True, error_model="numpy", nogil=True)
    return decorate


def named(kind: type[tuple[Any, ...]], *fields: Any) -> Any:
    """The type of a NamedTuple as compiled code sees it, from those of its fields."""
    if len(set(fields)) == 1:
        return numba.types.NamedUniTuple(fields[0], len(fields), kind)  # type: ignore[no-untyped-call]
    return numba.types.NamedTuple(fields, kind)  # type: ignore[no-untyped-call]
