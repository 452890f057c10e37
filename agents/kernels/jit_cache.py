"""Where compiled kernels are kept, and whether they are there; it does without numba, which is slow to import."""

import hashlib
import os
import shutil
from importlib.metadata import version
from pathlib import Path

_HERE = Path(__file__).parent
_FILES = [file for file in sorted(_HERE.glob("*.py")) if file.stem not in ("__init__", "jit", "jit_cache")]
KERNEL_MODULES = [f"agents.kernels.{file.stem}" for file in _FILES]
"""Every module of kernels; importing one compiles it."""
_SOURCES = [*_FILES, _HERE / "jit.py", _HERE.parents[1] / "formation" / "unicycle.py"]


def cache_folder() -> Path:
    """$ECHELON_CACHE, else the user's cache folder; in it one folder per version of the sources.

    numba's own cache does not notice a change in a function that a cached one calls from another file, so the
    folder's name carries a digest of all of them.
    """
    base = os.environ.get("ECHELON_CACHE") or os.environ.get("XDG_CACHE_HOME") or str(Path.home() / ".cache")
    digest = hashlib.sha256(version("numba").encode())
    for source in _SOURCES:
        digest.update(source.read_bytes())
    return Path(base) / "echelon" / f"kernels-{digest.hexdigest()[:16]}"


def compiled() -> bool:
    """Whether every kernel has been compiled on this machine."""
    return (cache_folder() / "complete").exists()


def fetch_prebuilt() -> None:
    """Copy kernels that an image brings with it in $ECHELON_PREBUILT: numba only loads from where it may write."""
    prebuilt = os.environ.get("ECHELON_PREBUILT")
    if prebuilt and not compiled():
        source = Path(prebuilt) / "echelon" / cache_folder().name
        if source.is_dir():
            shutil.copytree(source, cache_folder(), dirs_exist_ok=True)


def note_compiled() -> None:
    """Every kernel has just been compiled or loaded."""
    folder = cache_folder()
    if folder.is_dir():
        (folder / "complete").touch()
