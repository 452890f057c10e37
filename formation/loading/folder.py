"""Imports of a file of a user's own: it finds what lies beside it, and nobody else does.

Every folder becomes a package with a private name, so that two files `mine.py` in two folders are two modules, each
with its own neighbours. Inside it, `import helper` means the helper.py beside the file, as it does for a script.
"""

import builtins
import importlib
import itertools
import linecache
import sys
from collections.abc import Sequence
from importlib.abc import InspectLoader, MetaPathFinder
from importlib.machinery import ModuleSpec
from importlib.util import spec_from_loader
from pathlib import Path
from types import ModuleType
from typing import Any

from formation.loading.source import read

PREFIX = "echelon_own_"
OURS = frozenset(
    {
        "echelon",
        "formation",
        "network",
        "agents",
        "world",
        "records",
        "ros",
        "dashboard",
        "runtime",
        "experiments",
        "api",
        "cli",
    }
)
"""Never sought beside a file: what the product hands out must be the product's own."""
_numbers = itertools.count(1)
_folders: dict[str, "Folder"] = {}


class Folder:
    """The folder of one file, as a package of its own."""

    def __init__(self, path: Path, texts: dict[str, str]) -> None:
        """A package that is not imported yet.

        Args:
            path: of the folder.
            texts: by path from the folder, used instead of the files; texts that are read are added.
        """
        self.path, self.texts = path, texts
        self.package = f"{PREFIX}{next(_numbers)}"
        if not any(isinstance(finder, _Finder) for finder in sys.meta_path):
            sys.meta_path.insert(0, _Finder())
        _folders[self.package] = self
        root = ModuleType(self.package)
        root.__path__ = []
        sys.modules[self.package] = root

    def module(self, name: str) -> ModuleType:
        """Import a module of the folder by its dotted name."""
        return importlib.import_module(f"{self.package}.{name}")

    def locate(self, name: str) -> str | None:
        """The path from the folder of a module by its dotted name; None if there is none."""
        stem = name.replace(".", "/")
        for path in (f"{stem}/__init__.py", f"{stem}.py"):
            if path not in self.texts and (self.path / path).is_file():
                self.texts[path] = read(self.path / path, str(self.path / path))
            if path in self.texts:
                return path
        return None

    def import_from_inside(
        self,
        name: str,
        globals: dict[str, Any] | None = None,
        locals: dict[str, Any] | None = None,
        fromlist: Sequence[str] | None = (),
        level: int = 0,
    ) -> ModuleType:
        """What an import statement in a file of the folder calls."""
        first = name.partition(".")[0]
        if level or first in OURS or self._is_known(first) or self.locate(first) is None:
            return builtins.__import__(name, globals, locals, fromlist or (), level)
        module = self.module(name)
        if not fromlist:
            return self.module(first)
        for item in fromlist:
            if not hasattr(module, item) and self.locate(f"{name}.{item}"):
                self.module(f"{name}.{item}")
        return module

    def _is_known(self, first: str) -> bool:
        """Whether the file beside is imported already under its public name."""
        known = getattr(sys.modules.get(first), "__file__", None)
        return known is not None and Path(known).parent in (self.path, self.path / first)


class _Finder(MetaPathFinder):
    def find_spec(
        self, fullname: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        package, _, name = fullname.partition(".")
        folder = _folders.get(package)
        place = folder.locate(name) if folder and name else None
        if folder is None or place is None:
            return None
        return spec_from_loader(fullname, _Loader(folder, place), is_package=place.endswith("/__init__.py"))


class _Loader(InspectLoader):
    def __init__(self, folder: Folder, place: str) -> None:
        self._folder, self._file = folder, str(folder.path / place)
        self._text, self._package = folder.texts[place], place.endswith("/__init__.py")

    def is_package(self, fullname: str) -> bool:
        return self._package

    def get_source(self, fullname: str) -> str:
        return self._text

    def get_filename(self, fullname: str) -> str:
        return self._file

    def exec_module(self, module: ModuleType) -> None:
        # Tracebacks quote the text that runs, whatever the file holds by then.
        linecache.cache[self._file] = (len(self._text), None, self._text.splitlines(keepends=True), self._file)
        module.__file__ = self._file
        module.__dict__["__builtins__"] = {**vars(builtins), "__import__": self._folder.import_from_inside}
        exec(compile(self._text, self._file, "exec", dont_inherit=True), module.__dict__)
