"""How numeric code is compiled: ahead of the first call, once per machine.

agents/kernels/jit_cache.py says where the result is kept. Arguments of a kernel that Python calls are single arrays and
numbers: an array costs 0.13 us per call, a number 0.05 us, one in a NamedTuple 0.3 us, and its arrays must not be
read-only. With `entry_for` it is half of that, and arrays may be read-only. A state of many arrays therefore lies in
one or two flat ones, of which the kernel makes a NamedTuple of views (`window.state.window_of`); callers group other
arguments in NamedTuples and pass `*task`.
"""

import hashlib
import importlib
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Literal

from agents.kernels.jit_cache import cache_folder, compiled, fetch_prebuilt

fetch_prebuilt()
if not compiled():
    sys.stderr.write("the solver is not compiled for this machine yet: compiling (about half a minute) ...\n")


@contextmanager
def _without(*modules: str) -> Iterator[None]:
    """Whoever imports one of these meanwhile finds that there is none, unless it is loaded already."""
    hidden = [module for module in modules if module not in sys.modules]
    sys.modules.update(dict.fromkeys(hidden))  # type: ignore[arg-type]
    try:
        yield
    finally:
        for module in hidden:
            del sys.modules[module]


# What numba looks for as it loads, and no kernel uses: 0.25 s and 11 MB of every agent. scipy's BLAS would even decide
# over last bits (docs/design.md, section 12).
with _without("scipy.linalg", "cffi", "yaml"):
    import numba

    for part in ("numba.np.arraymath", "numba.core.typing.cffi_utils"):
        importlib.import_module(part)

_OURS: set[object] = set()
"""Code of the functions that the decorators below were given."""


class KernelLocator:
    """Where numba keeps what is compiled from one function (numba, NUMBA_CACHE_LOCATOR_CLASSES).

    numba's own locators go by the path of the source file, and fall back to other places if one cannot be written,
    where older machine code may lie. This one answers for every kernel, and for nothing else.
    """

    def __init__(self, function: Any, file: str) -> None:
        self._py_file = file  # by this name numba knows it
        self._function = function

    @classmethod
    def from_function(cls, function: Any, file: str) -> "KernelLocator | None":
        """The locator of a kernel; None for other functions, which are left to numba."""
        return cls(function, file) if function.__code__ in _OURS else None

    def ensure_cache_path(self) -> None:
        """Make the folder."""
        cache_folder().mkdir(parents=True, exist_ok=True)

    def get_cache_path(self) -> str:
        """The folder, as numba joins paths."""
        return str(cache_folder())

    def get_source_stamp(self) -> str:
        """Of the function's own file; what it calls counts in the folder's name."""
        return hashlib.sha256(Path(self._py_file).read_bytes()).hexdigest()

    def get_disambiguator(self) -> str:
        """What tells functions of one name apart."""
        return f"{self._function.__module__}-{self._function.__code__.co_firstlineno}"


_OTHERS = getattr(numba.config, "CACHE_LOCATOR_CLASSES") or ",".join(  # noqa: B009  the module has no types
    f"{kind}CacheLocator" for kind in ("UserProvided", "InTree", "UserWide", "IPython", "Zip")
)
setattr(numba.config, "CACHE_LOCATOR_CLASSES", f"{__name__}.KernelLocator,{_OTHERS}")  # noqa: B010

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


def _compile(
    function: Callable[..., Any],
    signature: Any = None,
    *,
    inline: Literal["never", "always"] = "never",
    short: bool = False,
) -> Callable[..., Any]:
    _OURS.add(function.__code__)
    decorate: Callable[..., Any] = numba.njit(
        signature, cache=True, error_model="numpy", nogil=not short, inline=inline
    )
    compiled_function: Callable[..., Any] = decorate(function)
    return compiled_function


def kernel(function: Callable[..., Any]) -> Callable[..., Any]:
    """Decorator for a function that other kernels call: compiled with its caller."""
    return _compile(function)


def inlined(function: Callable[..., Any]) -> Callable[..., Any]:
    """The same, and its text becomes a part of its caller's: what is constant there is constant in it.

    The compiler then unrolls its loops: a step of two robots by the code for n takes 19 us without and 12.5 us with it.
    """
    return _compile(function, inline="always")


def kernel_for(result: Any, *arguments: Any) -> Callable[[Callable[..., Any]], Callable[..., Any]]:
    """Decorator for a function that Python calls: compiled, or loaded from the cache, on import."""
    return lambda function: _compile(function, result(*arguments))


CHECKED: dict[Callable[..., Any], Callable[..., Any]] = {}
"""Of each function that `entry_for` has made, the same as `kernel_for` makes it: it refuses wrong arguments."""


def entry_for(result: Any, *arguments: Any) -> Callable[[Callable[..., Any]], Callable[..., Any]]:
    """The same for a function that Python calls at every tick, and no kernel: called without numba's dispatcher.

    That looks at each argument to choose among versions, of which there is one, and takes half of the time of a call.
    Without it nobody sees a wrong argument: arrays must be of the declared numbers, and contiguous where it says so.
    It keeps Python's lock: it takes microseconds, and who gets the lock meanwhile may keep it for milliseconds.
    """

    def decorate(function: Callable[..., Any]) -> Callable[..., Any]:
        chooser: Any = _compile(function, result(*arguments), short=True)
        (version,) = chooser.overloads.values()
        entry: Callable[..., Any] = version.entry_point
        CHECKED[entry] = chooser
        return entry

    return decorate


def named(kind: type[tuple[Any, ...]], *fields: Any) -> Any:
    """The type of a NamedTuple as compiled code sees it, from those of its fields."""
    if len(set(fields)) == 1:
        return numba.types.NamedUniTuple(fields[0], len(fields), kind)  # type: ignore[no-untyped-call]
    return numba.types.NamedTuple(fields, kind)  # type: ignore[no-untyped-call]


def several(*results: Any) -> Any:
    """The type of a kernel's result that is a tuple of these."""
    return numba.types.Tuple(results)  # type: ignore[no-untyped-call]
