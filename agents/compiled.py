"""How numeric code is compiled: ahead of the first call, once per machine, and cached under a key of its sources.

numba's own cache does not notice a change in a function that a cached one calls from another file, so the
folder's name carries a digest of all of them.
"""

import hashlib
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numba

_SOURCES = sorted(Path(__file__).parent.glob("*kernel*.py"))
_SOURCES.append(Path(__file__).parent.parent / "formation" / "unicycle.py")


def cache_folder() -> Path:
    """Where compiled kernels are kept: $ECHELON_CACHE, else the user's cache folder."""
    base = os.environ.get("ECHELON_CACHE")
    if base is None:
        base = str(Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "echelon")
    digest = hashlib.sha256(numba.__version__.encode())
    for source in _SOURCES:
        digest.update(source.read_bytes())
    return Path(base) / f"kernels-{digest.hexdigest()[:16]}"


numba.config.CACHE_DIR = str(cache_folder())

REAL, WHOLE, NOTHING = numba.float64, numba.int64, numba.void
VECTOR, MATRIX, TABLE = (numba.types.Array(REAL, n, "C", readonly=True) for n in (1, 2, 3))
"""Contiguous arrays that a kernel only reads, writable or not."""
STRIDED_VECTOR, STRIDED = (numba.types.Array(REAL, n, "A", readonly=True) for n in (1, 2))
"""The same with any layout; slower."""
FLAGS = numba.types.Array(numba.boolean, 1, "C", readonly=True)
VECTOR_OUT, MATRIX_OUT, STRIDED_OUT = numba.float64[::1], numba.float64[:, ::1], numba.float64[:, :]
"""Arrays that a kernel writes."""

kernel: Callable[..., Any] = numba.njit(cache=True, error_model="numpy", nogil=True)
"""Decorator for a function that other kernels call: compiled with its caller."""


def kernel_for(result: Any, *arguments: Any) -> Callable[..., Any]:
    """Decorator for a function that Python calls: compiled, or loaded from the cache, on import."""
    decorate: Callable[..., Any] = numba.njit(result(*arguments), cache=True, error_model="numpy", nogil=True)
    return decorate
