"""Where compiled kernels are kept, and whether they are there; it does without numba, which is slow to import.

The folder's name carries a digest of everything that the machine code depends on: the text of all kernels, the versions
of numba and Python, and the processor. The path of the checkout and the time stamps of its files are no part of it, so
that two checkouts of the same sources share their kernels, and `complete` is right for both.
"""

import functools
import hashlib
import os
import platform
import shutil
import stat
import sys
import tempfile
from importlib.metadata import version
from pathlib import Path

from formation.errors import EchelonError

_HERE = Path(__file__).parent
_FILES = [file for file in sorted(_HERE.rglob("*.py")) if file.stem not in ("__init__", "jit", "jit_cache")]
KERNEL_MODULES = [".".join(("agents.kernels", *file.relative_to(_HERE).with_suffix("").parts)) for file in _FILES]
"""Every module of kernels; importing one compiles it."""
_SHARED = [_HERE.parents[1] / "formation" / name for name in ("unicycle.py", "clear/stopping.py")]
"""Of which kernels are made as well."""
_SOURCES = [*_FILES, _HERE / "jit.py", *_SHARED]
_CPUINFO = Path("/proc/cpuinfo")
_COMPLETE = "complete"
"""The mark in a folder in which every kernel is."""


def cache_folder() -> Path:
    """The folder of the kernels, below the place that the user wants or a private temporary one (`writable`)."""
    wanted = wanted_place()
    return (wanted if wanted and writable(wanted) else _private_place()) / _folder_name()


def wanted_place() -> Path | None:
    """$ECHELON_CACHE, else the user's cache folder; None if there is no home of this user either."""
    if named := os.environ.get("ECHELON_CACHE"):
        return Path(named).absolute()
    if (cache := Path(os.environ.get("XDG_CACHE_HOME", ""))).is_absolute():
        return cache
    try:
        home = Path.home()
        # After sudo it may be another user's; a relative one would be a folder of whatever lies in the current one.
        return home / ".cache" if home.is_absolute() and home.stat().st_uid == os.getuid() else None
    except (OSError, RuntimeError):  # a user without an entry in the system's list, or whose home does not exist
        return None


def writable(place: Path) -> bool:
    """Whether this process may make folders in it; nothing is written to find out."""
    existing = next((path for path in (place / "echelon", *(place / "echelon").parents) if path.exists()), place)
    return existing.is_dir() and os.access(existing, os.W_OK | os.X_OK)


def compiled() -> bool:
    """Whether every kernel has been compiled for this machine."""
    return (cache_folder() / _COMPLETE).exists()


def fetch_prebuilt() -> None:
    """Copy kernels that are complete where this process may not write: in $ECHELON_PREBUILT, or in the wanted place.

    A kernel that is called with other types than usual is compiled and kept then, so the folder must be writable.
    """
    folder = cache_folder()
    if folder.exists():
        return
    for place in (Path(named) if (named := os.environ.get("ECHELON_PREBUILT")) else None, wanted_place()):
        source = place / _folder_name() if place else folder
        if source != folder and (source / _COMPLETE).exists():
            folder.parent.mkdir(parents=True, exist_ok=True)
            half = Path(tempfile.mkdtemp(prefix="copy-", dir=folder.parent))
            shutil.copytree(source, half, dirs_exist_ok=True)
            try:
                half.rename(folder)  # whole at once: other processes look for it meanwhile
            except OSError:  # another one was first
                shutil.rmtree(half)
            return


def note_compiled() -> None:
    """Every kernel has just been compiled or loaded."""
    folder = cache_folder()
    if folder.is_dir():
        (folder / _COMPLETE).touch()


def _private_place() -> Path:
    """A folder in the temporary one that belongs to this user alone: what lies in it is run as code.

    Raises:
        EchelonError: somebody else has taken its name, or there can be none.
    """
    place = Path(f"echelon-cache-{os.getuid()}")
    try:
        place = Path(tempfile.gettempdir()) / place
        place.mkdir(mode=0o700, exist_ok=True)
        found = place.lstat()
    except OSError as error:
        raise EchelonError(
            f"compiled kernels can be kept neither in {wanted_place()} nor in {place} ({error.strerror}); "
            "set ECHELON_CACHE to a folder that can be written"
        ) from error
    if not stat.S_ISDIR(found.st_mode) or found.st_uid != os.getuid() or found.st_mode & 0o022:
        raise EchelonError(
            f"{place}: expected a folder that only this user can write; set ECHELON_CACHE to another folder"
        )
    return place


def _folder_name() -> Path:
    return Path("echelon") / f"kernels-{_digest()}"


@functools.cache
def _digest() -> str:
    versions = (version("numba"), version("llvmlite"), sys.implementation.cache_tag)
    digest = hashlib.sha256(repr((versions, _processor())).encode())
    for source in _SOURCES:
        digest.update(source.name.encode() + b"\0" + source.read_bytes())
    return digest.hexdigest()[:16]


def _processor() -> tuple[str, ...]:
    """What machine code depends on; numba compiles for the processor's model and its extensions."""
    try:
        lines = _CPUINFO.read_text(encoding="utf-8").split("\n\n", 1)[0].splitlines()
    except OSError:  # not Linux
        return platform.machine(), platform.processor()
    named = [line for line in lines if line.split("\t")[0].strip().lower() in ("model name", "flags", "features")]
    return (platform.machine(), *named, *(os.environ.get(f"NUMBA_CPU_{what}", "") for what in ("NAME", "FEATURES")))
